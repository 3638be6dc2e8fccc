#pragma once

namespace brim {

/// Optional interface of bodies that may begin to move without being touched, as fluids and driven joints do: while
/// they are restless they never sleep (WorldOptions::sleep). What is prescribed (Body::prescribe) wakes by itself.
class Restless {
 public:
  virtual ~Restless() = default;
  virtual bool restless() const = 0;
};

}  // namespace brim
