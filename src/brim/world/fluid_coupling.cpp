#include "brim/world/fluid_coupling.h"

#include <algorithm>
#include <cmath>

#include "brim/core/interface_of.h"
#include "brim/core/profile.h"
#include "brim/world/part_filter.h"

namespace brim {

namespace {

/// The part as a fluid; a frozen fluid is handled by contact instead.
const FlowsAround* fluid_of(const WorldPart& p) {
  return p.info.conforming && !p.frozen ? interface_of<FlowsAround>(*p.body) : nullptr;
}

}  // namespace

bool flows_around(const WorldPart& a, const WorldPart& b) {
  if (a.info.conforming == b.info.conforming) return false;
  const FlowsAround *fa = fluid_of(a), *fb = fluid_of(b);
  return (fa != nullptr && fa->flows_around(b.info)) || (fb != nullptr && fb->flows_around(a.info));
}

std::vector<FluidCoupling::Fluid> FluidCoupling::find_fluids(std::span<const std::unique_ptr<Body>> bodies,
                                                             std::span<const WorldPart> parts) const {
  std::vector<Fluid> fluids;
  for (std::size_t f = 0; f < parts.size(); ++f) {
    if (fluid_of(parts[f]) == nullptr) continue;
    Fluid& fluid = fluids.emplace_back();
    fluid.flow = dynamic_cast<FlowsAround*>(bodies[parts[f].body_index].get());
    fluid.part = static_cast<std::int32_t>(f), fluid.body = parts[f].body_index;
    for (std::size_t s = 0; s < parts.size(); ++s)
      if (flows_around(parts[f], parts[s]) && rules_allow(parts[f], parts[s])) {
        Side& side = fluid.sides.emplace_back();
        side.part = static_cast<std::int32_t>(s), side.body = parts[s].body_index;
      }
  }
  return fluids;
}

void FluidCoupling::find(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
                         PartFilter& filter, std::span<const double> q, std::span<const std::size_t> first_v,
                         std::span<double> v) {
  std::vector<Fluid> fluids = find_fluids(bodies, parts);
  look_.clear();
  for (const Fluid& f : fluids) {
    look_.push_back(f.part);
    for (const Side& s : f.sides) look_.push_back(s.part);
  }
  if (fluids.empty() && found_.empty()) return;
  const bool known = look_ == found_ &&
                     std::ranges::all_of(fluids, [](const Fluid& f) { return f.flow->has_taken_solids(); }) &&
                     std::equal(q.begin(), q.end(), found_q_.begin(), found_q_.end()) &&
                     std::equal(bodies.begin(), bodies.end(), body_.begin(), body_.end(),
                                [](const auto& a, const Body* b) { return a.get() == b; });
  if (known) return;
  found_ = look_, found_q_.assign(q.begin(), q.end());
  first_.assign(first_v.begin(), first_v.end());
  body_.clear();
  for (const auto& b : bodies) body_.push_back(b.get());
  drag_.clear();
  for (Fluid& fluid : fluids) {
    const ProfileScope scope("flows around", *parts[fluid.part].body);
    find_shares(fluid, parts, filter);
    fluid.flow->set_solids(octant_, v.empty() ? v : slice(v, fluid.body));
    if (!fluid.sides.empty()) find_rows(fluid, parts);
    for (const Side& s : fluid.sides) drag_.add(*fluid.flow, fluid.body, parts[s.part], s.part, *s.eighths);
    fluid.told = !octant_.empty();
  }
  // A fluid that knows of solids leaves its pressure to the solve, even if they are far from its wet cells.
  std::erase_if(fluids, [](const Fluid& f) { return !f.told; });
  fluids_ = std::move(fluids);
  for (Fluid& f : fluids_) {
    const std::size_t n = f.flow->flow_grid().cells();
    for (auto* x : {&f.pressure, &f.guess, &f.x, &f.r, &f.p, &f.y, &f.z}) x->assign(n, 0.0);
  }
}

void FluidCoupling::find_shares(Fluid& fluid, std::span<const WorldPart> parts, PartFilter& filter) {
  const MacGrid& g = fluid.flow->flow_grid();
  octant_.clear();
  for (Side& side : fluid.sides) {
    side.eighths = &shares_.of({fluid.part, side.part}, g, parts[side.part]);
    if (const WorldPart& a = parts[fluid.part], &b = parts[side.part]; PartFilter::concerns(a, b)) {
      filter.follow(a), filter.follow(b);
      std::vector<Eighth>& left = left_by_filter_[{fluid.part, side.part}];
      left = *side.eighths;
      const Vec3i n = 2 * g.n;
      std::erase_if(left, [&](const Eighth& e) {
        const Vec3i at(e.place % n.x(), e.place / n.x() % n.y(), e.place / (n.x() * n.y()));
        return !filter.touch(a, b, g.origin + 0.5 * g.dx * (at.cast<double>() + Vec3::Constant(0.5)));
      });
      side.eighths = &left;
    }
    if (side.eighths->empty()) continue;
    if (octant_.empty()) octant_.assign(8 * g.cells(), 0.0f);
    for (const Eighth& e : *side.eighths) octant_[e.place] += e.share;
  }
  std::erase_if(fluid.sides, [](const Side& s) { return s.eighths->empty(); });
}

void FluidCoupling::give_back(std::span<const double> residual, std::span<double> delta) const {
  for (const Fluid& f : fluids_) {
    const Body& body = *body_[f.body];
    const auto left = slice(residual, f.body);
    const auto change = slice(delta, f.body);
    std::vector<double> all(left.size()), impulse(left.size());
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = i % 3 == a ? 1.0 : 0.0;
      body.filter(all);
      std::fill(impulse.begin(), impulse.end(), 0.0);
      body.apply_mass(all, impulse);
      double lost = 0.0, mass = 0.0;
      for (std::size_t i = a; i < all.size(); i += 3) lost += all[i] * left[i], mass += all[i] * impulse[i];
      if (!(mass > 0.0)) continue;
      for (std::size_t i = a; i < all.size(); i += 3) change[i] += lost / mass * all[i];
    }
  }
}

void FluidCoupling::report(double dt, std::span<const double> v, StepReport& report,
                           std::vector<ContactSample>& samples) {
  for (const Fluid& f : fluids_)
    for (const Side& s : f.sides) {
      PairReport r;
      r.part_a = std::min(f.part, s.part), r.part_b = std::max(f.part, s.part);
      r.contacts = static_cast<std::int32_t>(s.rows.size());
      Vec3 on_solid = Vec3::Zero();
      double load = 0.0;
      for (std::size_t i = 0; i < s.rows.size(); ++i) {
        const Row& row = s.rows[i];
        const double push =
            row.area / dt * ((row.low >= 0 ? f.pressure[row.low] : 0.0) - (row.high >= 0 ? f.pressure[row.high] : 0.0));
        on_solid[row.axis] += push;
        if (push != 0.0) {
          const Vec3 on_a = (s.part < f.part ? push : -push) * Vec3::Unit(row.axis);
          samples.push_back({s.points[i].cast<float>(), on_a.cast<float>(), Vec3f::Zero(), 0.0f, r.part_a, r.part_b});
        }
        r.center += std::abs(push) * s.points[i];
        load += std::abs(push);
      }
      if (load > 0.0) r.center /= load;
      drag_.for_forces(f.body, s.part, v, [&](const Vec3& x, const Vec3& force) {
        on_solid += force;
        const Vec3 on_a = s.part < f.part ? force : Vec3(-force);
        samples.push_back({x.cast<float>(), Vec3f::Zero(), on_a.cast<float>(), 0.0f, r.part_a, r.part_b});
      });
      r.force_on_a = s.part < f.part ? on_solid : Vec3(-on_solid);
      report.contacts += r.contacts;
      report.pairs.push_back(r);
    }
  std::sort(report.pairs.begin(), report.pairs.end(), [](const PairReport& r, const PairReport& s) {
    return r.part_a != s.part_a ? r.part_a < s.part_a : r.part_b < s.part_b;
  });
}

}  // namespace brim
