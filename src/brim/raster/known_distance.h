#pragma once

namespace brim {

/// What a Shape is besides where its density is ramp(distance, w), and distance changes by no more than the point moves
/// but for errors of at most slack.
class KnownDistance {
 public:
  virtual ~KnownDistance() = default;
  virtual double slack() const = 0;  ///< [m]
};

}  // namespace brim
