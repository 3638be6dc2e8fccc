#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "brim/contact/cube_contacts.h"
#include "brim/response/constraint.h"
#include "brim/response/moved_rows.h"
#include "brim/world/reference_poses.h"
#include "brim/world/step_report.h"
#include "brim/world/world_part.h"

namespace brim {

struct WorldOptions;
class ContactParameters;
class PosedShape;

/// Pairs of rigid solids held by rows: rigid bodies, links of articulated bodies and obstacles. They are sampled at
/// their references (ReferencePoses), gathered to rows at once, and cached: while both references and the margin are
/// unchanged, a pair only moves its rows along. The cached data depend only on references and margin, never on how long
/// they have been cached. Tests: tests/world/rigid_contacts_test.cpp
class RigidContacts {
 public:
  RigidContacts();
  ~RigidContacts();

  /// Finds the parts that are rigid solids, and their contact parameters.
  void start(std::span<const WorldPart> parts, const ContactParameters& laws, const WorldOptions& options);
  /// Takes the references of a state and clears the cache.
  void restore(std::span<const double> memory);
  /// True when rows hold the two parts apart and both are rigid solids.
  bool holds(std::int32_t a, std::int32_t b) const { return class_[a] >= 0 && class_[b] >= 0 && law(a, b).constrained; }
  bool any() const { return any_; }

  /// Updates the poses of the solids.
  /// @param coarsest  coarsest level of any part: boxes include its ramp
  void follow(int coarsest = 0);
  /// Bounding box for contact of a part at its reference, [m]; for parts known to holds.
  const Aabb& box(std::int32_t part) const { return box_[part]; }
  bool follows(std::int32_t part) const { return class_[part] >= 0; }
  /// False when the references' boxes without ramp are farther apart than a gap, [m].
  bool leaves_room(std::int32_t a, std::int32_t b, double gap) const {
    const Vec3 apart = (box_[a].lo - box_[b].hi).cwiseMax(box_[b].lo - box_[a].hi);
    return apart.maxCoeff() + half_ramp_[a] + half_ramp_[b] <= gap;
  }

  /// Two parts whose boxes overlap. @param margin  as in ContactPair
  struct Touch {
    std::int32_t part_a, part_b;
    double h, w, margin;
    int level = 0;  ///< at which they meet
  };
  /// Samples the pairs that are not cached. @param touches  ordered by part numbers, only pairs with holds()
  /// @param average  coarse densities are means of fine ones
  void find(std::span<const Touch> touches, bool every_node, bool average = true);
  /// All rows, at the present poses.
  GatheredRows gather();

  std::int64_t contacts() const { return contacts_; }  ///< of all pairs
  /// Calls f(part_a, part_b) for the pairs with contacts.
  template <class F>
  void for_pairs(const F& f) const {
    for (const Pair& p : pairs_)
      if (p.contacts > 0) f(p.touch.part_a, p.touch.part_b);
  }
  /// The same for pairs of which nodes were sampled, with contacts or not.
  template <class F>
  void for_near(const F& f) const {
    for (const Pair& p : pairs_)
      if (p.contacts > 0 || p.nodes > 0) f(p.touch.part_a, p.touch.part_b);
  }
  std::int64_t engulfed() const { return engulfed_; }
  /// report adds the reports of pairs, in order; count_work the work of the last find.
  void report(std::span<const WorldPart> parts, double time, StepReport& report) const;
  void count_work(StepReport& report) const;
  /// Appends the nodes sampled in both parts, with their steps.
  void append_boxes(std::vector<std::pair<NodeBox, double>>& out) const;
  /// Writes the references that differ from the solids' poses in front of memory.
  void keep(std::vector<double>& memory) const;

 private:
  /// Results at the references.
  struct Pair {
    Touch touch;
    std::uint64_t stamp_a = 0, stamp_b = 0;
    std::int32_t contacts = 0;             ///< nodes, or rows read between nodes
    std::int64_t engulfed = 0, nodes = 0;  ///< samples, at nodes and between
    float most_overlap = 0.0f;             ///< [-] ρ̄
    bool off_nodes = false;                ///< rows were gathered from nodes
    RowPoint deepest;                      ///< the node of the largest depth
    std::vector<RowPoint> rows;
    std::vector<NodeBox> boxes;
  };
  struct Workspace;
  struct Workspaces;
  const ConstraintPair& law(std::int32_t a, std::int32_t b) const { return laws_[class_[a] * classes_ + class_[b]]; }
  /// True when the distance of b's origin from a excludes a gap of at most `gap`, [m].
  bool apart(std::int32_t a, std::int32_t b, double gap) const;
  void sample(Pair& pair, Workspace& workspace, bool every_node) const;
  /// A solid at its reference, as seen by a pair.
  CubeSide side_of(std::int32_t part, const Touch& t) const;
  /// Reads the rows of two convex solids between the nodes. @return false when that is impossible
  bool read_between(Pair& pair, const Aabb& region, double gap) const;

  std::vector<std::int32_t>
      class_;  ///< per part: class of parts with equal contact parameters; −1 when not a rigid solid
  std::int32_t classes_ = 0;
  std::vector<ConstraintPair> laws_;  ///< shape (classes, classes)
  bool any_ = false, average_ = true;
  double finest_ = 0.0;            ///< [m] finest step of any part
  std::vector<double> half_ramp_;  ///< [m] per part, at the coarsest level
  int coarsest_ = 0;
  std::vector<double> reach_;  ///< [m] per part, distance of its farthest point from its origin; 0 if unknown
  std::vector<const PosedShape*> solid_;  ///< per part, or null
  std::vector<CubeSide> side_;            ///< per part, at its reference
  std::vector<Aabb> box_;
  ReferencePoses references_;
  std::vector<Pair> pairs_, kept_;
  std::vector<std::size_t> fresh_;
  double most_rows_ = 0.0;  ///< number of rows that memory_limit allows
  std::vector<PairRows> pair_rows_;
  std::vector<RowPoint> rows_;
  std::int64_t contacts_ = 0, engulfed_ = 0;
  std::unique_ptr<Workspaces> workspaces_;
};

}  // namespace brim
