/// What reports say of links: force, error, coordinate, energy; and which of them break.
#include <fmt/format.h>

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

void Links::finish(const ContactSet& set, std::span<const Vec3> force, double time, StepReport& report) {
  report.links.clear();
  for (std::size_t l = 0; l < links_.size(); ++l) {
    report.links.push_back({});
    report.links.back().broken = links_[l]->broken;
  }
  const std::size_t first = set.first_link();
  for (std::size_t i = 0; i < ties_.size(); ++i) {
    const Tie& tie = ties_[i];
    LinkReport& r = report.links[tie.link];
    const Hold hold = links_[tie.link]->held[tie.held].hold;
    // A force along a rotational coordinate is half of a couple: the held points provide the other half.
    r.force += force[first + i];
    if (along_coordinate(hold)) {
      r.effort += tie.lever * tie.n.dot(force[first + i]);
      continue;
    }
    r.error = std::max(r.error, tie.error.norm());
  }
  for (std::size_t l = 0; l < links_.size(); ++l) {
    Link& link = *links_[l];
    const double error = report.links[l].error;
    if (link.given.stiffness > 0.0 || link.told || link.broken || !(error > link.apart)) continue;
    link.told = true;
    if (report.warnings.size() < kMostWarnings)
      report.warnings.push_back(
          {time, "link_apart",
           fmt::format("'{}' is rigid and {:.2g} m apart: its bodies turn too fast, or are pulled "
                       "too hard, for the sub-step; take shorter ones (time_step, min_substeps)",
                       link.given.name, error)});
  }
  break_overloaded(time, report);
  report.links.resize(kept());
}

void Links::break_overloaded(double time, StepReport& report) {
  std::size_t untold = 0;
  for (std::size_t l = 0; l < links_.size(); ++l) {
    const double load = report.links[l].force.norm();
    if (links_[l]->broken || !(load > links_[l]->given.break_force)) continue;
    links_[l]->broken = report.links[l].broken = true;
    if (report.warnings.size() < kMostWarnings)
      report.warnings.push_back({time, "link_broken",
                                 fmt::format("'{}' broke: it carried {:.4g} N, above {:.4g} N", links_[l]->given.name,
                                             load, links_[l]->given.break_force)});
    else
      ++untold;
  }
  if (untold > 0)
    report.warnings.push_back(
        {time, "link_broken", fmt::format("and {} more broke at the same time; the run's links say which", untold)});
}

}  // namespace brim
