#include <algorithm>
#include <cmath>
#include <numbers>

#include "brim/body/articulated/joint_forces.h"
#include "brim/world/links.h"

namespace brim {

double Links::spring_energy(const Link& link, const Coordinate& c, double time) {
  double energy = 0.0;
  for (const Held& held : link.held) {
    if (held.hold == Hold::Drive) {
      const JointDrive& d = link.given.joint->drive;
      double miss = target_of(link, time).first - c.value;
      if (link.given.joint->kind == JointKind::Revolute) miss = std::remainder(miss, 2.0 * std::numbers::pi);
      energy += drive_energy(d, miss);
    } else if (held.hold == Hold::Lower || held.hold == Hold::Upper) {
      const LinkJoint& j = *link.given.joint;
      const double beyond = std::max(held.hold == Hold::Upper ? c.value - j.upper : j.lower - c.value, 0.0);
      energy += 0.5 * j.limit_stiffness * beyond * beyond;
    } else if (link.given.stiffness > 0.0) {
      Vec3 n = Vec3::UnitZ(), error;
      stretch(link, held, c, time, n, error);
      if (held.hold == Hold::Along && link.given.pulls_only && n.dot(error) < 0.0) continue;
      energy += 0.5 * held.share * link.given.stiffness * error.squaredNorm();
    }
  }
  return energy;
}

void Links::measure(std::span<const WorldPart> parts, std::span<const double> q, std::span<const std::size_t> first_q,
                    double time, StepReport& report) {
  for (std::size_t l = 0; l < kept(); ++l) {
    Link& link = *links_[l];
    if (link.broken) continue;
    link.follow(parts, q, first_q);
    const Coordinate c = coordinate(link);
    if (l < report.links.size()) report.links[l].coordinate = c.value;
    report.potential_energy += spring_energy(link, c, time);
  }
}

}  // namespace brim
