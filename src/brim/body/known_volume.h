#pragma once

namespace brim {

/// Optional interface of bodies that know the volume of their matter.
class KnownVolume {
 public:
  virtual ~KnownVolume() = default;
  /// [m³] 0: unknown
  virtual double volume() const = 0;
};

}  // namespace brim
