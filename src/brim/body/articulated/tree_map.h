#pragma once

#include "brim/body/articulated/tree.h"
#include "brim/map/map.h"

namespace brim {

/// Contact stiffness of a tree's links, Jᵀ K J of each link at its origin: written by the maps when they make the block
/// diagonal, read by the tree's preconditioner. The blocks of single joints do not contain it.
struct TreeContact {
  std::vector<Mat6> inertia;  ///< [kg, kg m, kg m²], shape (links)
};

/// Map of one link: the rigid map of its twist composed with the twists of the joints between it and the world (paper,
/// sections 5.1 and 5.3):
///   u = U + Ω × (r − o),  (U, Ω) = Σ over joints j on the path of S_j v_j, moved to o
/// Costs O(path + points).
class TreeMap final : public Map {
 public:
  /// @param contact  receives the link's share from add_block_diagonal; may be null
  void reset(const Tree& tree, const TreePose& pose, int link, std::span<const Vec3> points, TreeContact* contact);

  std::size_t points() const override { return arm_.size(); }
  void apply(std::span<const double> v, std::span<Vec3> u) const override;
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override;
  /// Arms, axes and origins of the joints rotate with the links they are attached to.
  void add_geometric(std::span<const Vec3> f, std::span<const double> dq, std::span<double> Q) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;

 private:
  struct Joint {
    std::size_t v0;  ///< row in v
    int column;      ///< index in J_
    int dof, block;
    Vec3 offset;  ///< [m] of its origin from the link's
  };
  Vec6 twist(std::span<const double> v) const;

  int link_ = 0;
  TreeContact* contact_ = nullptr;
  std::vector<Joint> joint_;                    ///< from the world outwards
  Eigen::Matrix<double, 6, Eigen::Dynamic> J_;  ///< twist of the link per joint velocity on the path
  std::vector<Vec3> arm_;                       ///< r − o, [m]
};

}  // namespace brim
