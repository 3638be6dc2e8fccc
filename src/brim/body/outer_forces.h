#pragma once

#include <span>
#include <utility>
#include <vector>

namespace brim {

/// Optional interface of bodies that accept external forces besides gravity, along their own velocities. Set between
/// steps, they act in every sub-step, like gravity, until set again.
/// Tests: tests/body/outer_forces_test.cpp
class OuterForces {
 public:
  virtual ~OuterForces() = default;
  /// @param Q  [N, N·m] shape (nv), or empty: none
  void set_outer_forces(std::vector<double> Q) { outer_ = std::move(Q); }
  bool has_outer_forces() const { return !outer_.empty(); }

 protected:
  /// For add_forces.
  void add_outer_forces(std::span<double> Q) const {
    for (std::size_t i = 0; i < outer_.size(); ++i) Q[i] += outer_[i];
  }

 private:
  std::vector<double> outer_;
};

}  // namespace brim
