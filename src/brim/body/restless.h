#pragma once

namespace brim {

/// Optional interface of bodies that may begin to move without being touched, such as fluids and driven joints: while
/// restless they never sleep (WorldOptions::sleep). Prescribed motion (Body::prescribe) wakes by itself.
class Restless {
 public:
  virtual ~Restless() = default;
  virtual bool restless() const = 0;
};

}  // namespace brim
