/// The arcs on which the ends of links move within a sub-step.
#include <algorithm>
#include <limits>

#include "brim/world/arc.h"
#include "brim/world/links.h"

namespace brim {

namespace {

/// [voxels] of the change of an arc that another solve follows.
constexpr double kFollowed = 1e-3;
/// Change of an arc in one solve, relative to that in the one before, above which it will not settle.
constexpr double kSettles = 0.8;
/// Swing of pulled solids in a sub-step (Links::swing_pieces) from which on arcs are not followed.
constexpr double kFastSwing = 1.0;
/// Share of the arc at the start of the sub-step that stands for one that is not followed.
constexpr double kUnfollowed = 0.5;

}  // namespace

Vec3 Links::arc_of(const Tie& tie, const Vec3& straight, const Vec3& bend, const Arc& b) const {
  const Hold hold = links_[tie.link]->held[tie.held].hold;
  if (hold == Hold::Point) return bend;
  if (hold != Hold::Across) return Vec3::Zero();
  const Vec3 n = b.turned(tie.n), way = straight + bend, arc = way - n * n.dot(way) - straight;
  return arc - tie.n * tie.n.dot(arc);
}

template <class Take>
void Links::for_arcs(std::span<const WorldPart> parts, const Motion& motion, const ContactSet& set,
                     std::span<const Vec3> delta, const Take& take) {
  const auto arc = [&](std::int32_t part, int body) {
    return part < 0 ? Arc() : Arc(*parts[part].body, motion.q_of(body), motion.v_of(body), dt_);
  };
  const std::size_t first = set.first_link();
  for (std::size_t i = 0; i < ties_.size();) {
    const std::size_t l = ties_[i].link;
    const Link& link = *links_[l];
    const Arc a = arc(link.part_a, link.body_a), b = arc(link.part_b, link.body_b);
    for (; i < ties_.size() && ties_[i].link == l; ++i) {
      const Tie& tie = ties_[i];
      const Vec3 u = tie.velocity - tie.target + (delta.empty() ? Vec3(Vec3::Zero()) : delta[first + i]);
      take(ties_[i], arc_of(tie, dt_ * u, a.bend(set.point[first + i]) - b.bend(set.link_point_b[i]), b));
    }
  }
}

void Links::start_arcs(std::span<const WorldPart> parts, const Motion& motion, const ContactSet& set) {
  const bool followed = dt_ * swing_ < kFastSwing;
  bends_ = false;
  arc_changes_.assign(links_.size(), std::numeric_limits<double>::infinity());
  for_arcs(parts, motion, set, {}, [&](Tie& tie, const Vec3& arc) {
    tie.first_arc = arc;
    tie.arc = followed ? arc : Vec3(kUnfollowed * arc);
    bends_ = bends_ || (followed && arc.norm() > kFollowed * parts[links_[tie.link]->part_a].h);
  });
}

double Links::follow_arcs(std::span<const WorldPart> parts, const Motion& motion, const ContactSet& set,
                          std::span<const Vec3> delta, Penalty& response) {
  std::vector<double> change(links_.size(), 0.0);
  std::vector<Vec3> arcs;
  for_arcs(parts, motion, set, delta, [&](const Tie& tie, const Vec3& arc) {
    arcs.push_back(arc);
    const double limit = kFollowed * parts[links_[tie.link]->part_a].h;
    change[tie.link] = std::max(change[tie.link], (arc - tie.arc).norm() / limit);
  });
  double most = 0.0;
  for (std::size_t i = 0; i < ties_.size(); ++i) {
    Tie& tie = ties_[i];
    const double now = change[tie.link], before = arc_changes_[tie.link];
    if (before < 0.0 || !(now > 1.0)) continue;  // given up before, or settled
    tie.arc = now > kSettles * before ? Vec3(kUnfollowed * tie.first_arc) : arcs[i];
    most = std::max(most, now);
  }
  for (std::size_t l = 0; l < links_.size(); ++l)
    if (change[l] > 1.0 && arc_changes_[l] >= 0.0)
      arc_changes_[l] = change[l] > kSettles * arc_changes_[l] ? -1.0 : change[l];
  if (most > 1.0) response.set_bond_forces(bonds());
  return most;
}

}  // namespace brim
