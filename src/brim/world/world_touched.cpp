// What contact tells bodies: that they are touched, where, and by which impulses; and who is woken by it.
#include "brim/body/spinning_balls.h"
#include "brim/body/touched_surface.h"
#include "brim/body/walled.h"
#include "brim/core/interface_of.h"
#include "brim/world/ball_points.h"
#include "brim/world/world_impl.h"

namespace brim {

bool World::Impl::wake_touched() {
  bool woke = false;
  const auto touch = [&](std::int32_t a, std::int32_t b) {
    const auto i = static_cast<std::size_t>(parts[a].body_index), j = static_cast<std::size_t>(parts[b].body_index);
    woke = sleep.wake(i) || woke;
    woke = sleep.wake(j) || woke;
  };
  // Pairs of sleeping bodies, or of a sleeping and a fixed one, are not searched.
  for (const ContactPair& p : stage.contacts().pairs)
    if (p.begin < p.end) touch(p.part_a, p.part_b);
  stage.rigid().for_pairs(touch);
  if (woke) sleep.mark(parts, state.v, first_v);
  return woke;
}

void World::Impl::wake_in_fluids() {
  bool woke = false;
  coupling.for_pairs([&](int fluid, int solid) {
    woke = sleep.wake(static_cast<std::size_t>(fluid)) || woke;
    woke = sleep.wake(static_cast<std::size_t>(solid)) || woke;
  });
  if (woke) sleep.mark(parts, state.v, first_v);
}

void World::Impl::tell_touched() {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    auto* touched = interface_of<TouchedSurface>(*bodies[b]);
    if (touched == nullptr) continue;
    std::vector<Vec3> points;
    std::vector<std::uint8_t> by_fluid;
    const ContactSet& contacts = stage.contacts();
    for (const ContactPair& p : contacts.pairs) {
      const bool a = parts[p.part_a].body_index == static_cast<int>(b),
                 other = parts[p.part_b].body_index == static_cast<int>(b);
      for (std::size_t c = p.begin; c < p.end && (a || other); ++c) {
        points.push_back(a ? contacts.point[c] : contacts.point_b(c));
        by_fluid.push_back(parts[a ? p.part_b : p.part_a].info.conforming);
      }
    }
    touched->note_contacts(points, by_fluid);
  }
}

void World::Impl::tell_loads(double dt) {
  const ContactSet& contacts = stage.contacts();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    auto* balls = interface_of<SpinningBalls>(*bodies[b]);
    if (balls == nullptr) continue;
    std::vector<double> load(v(b).size() / 6, 0.0);
    const auto body = static_cast<std::int32_t>(b);
    add_fixed_loads(
        parts, contacts, body, [&](std::size_t c) { return response.expected_load(c); }, load);
    add_fixed_loads(
        parts, constraints.points(), body, [&](std::size_t c) { return constraints.first_impulse(c) / dt; }, load);
    balls->set_loads(load);
  }
}

void World::Impl::tell_walled(double dt, std::span<const double> mapped) {
  std::vector<double> found;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    auto* walled = interface_of<Walled>(*bodies[b]);
    if (walled == nullptr || !walled->confined()) continue;
    if (mapped.empty()) {
      found.assign(state.v.size(), 0.0);
      if (!contact_force.empty()) maps.add_forces(contact_force, found);
      mapped = found;
    }
    std::vector<double> impulse(first_v[b + 1] - first_v[b]);
    for (std::size_t i = 0; i < impulse.size(); ++i)
      impulse[i] = implicit.inner_impulse()[first_v[b] + i] + dt * mapped[first_v[b] + i];
    walled->note_impulse(impulse);
  }
}

}  // namespace brim
