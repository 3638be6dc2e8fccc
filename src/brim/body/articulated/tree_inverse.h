#pragma once

#include "brim/body/articulated/tree.h"

namespace brim {

/// x = (M + T + Σ Jᵀ W J)⁻¹ r in time linear in the number of links: Featherstone's articulated-body algorithm, with T
/// block-diagonal over the joints (drives, limits, damping) and W an inertia per link (from its contacts).
/// Tests: tests/body/tree_test.cpp
class TreeInverse {
 public:
  /// @param T  one per link, only the corner of the joint's size is used; symmetric, positive semi-definite
  /// @param W  one per link, at the link's origin, or empty
  /// @return false when some joint moves no mass: solve() must not be used then
  bool factor(const Tree& tree, const TreePose& pose, std::span<const Mat3> T, std::span<const Mat6> W = {});
  /// x = (...)⁻¹ r, shapes (nv). Refers to the pose of factor(), which must still exist.
  /// @param scratch  shape (links)
  void solve(std::span<const double> r, std::span<Vec6> scratch, std::span<double> x) const;
  /// Inertia felt by a joint while its parent is held: mean over its velocities, [kg m² or kg].
  double pivot(std::size_t link) const { return joint_[link].pivot; }

 private:
  struct Joint {
    Mat6 gain;     ///< first columns: I S D⁻¹
    Mat6 inverse;  ///< corner: D⁻¹, D = Sᵀ I S + T
    double pivot = 0.0;
  };
  const Tree* tree_ = nullptr;
  const TreePose* pose_ = nullptr;
  std::vector<Mat6> inertia_;  ///< articulated, during factor()
  std::vector<Joint> joint_;
};

}  // namespace brim
