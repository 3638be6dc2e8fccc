#include "brim/world/sleep.h"

#include <algorithm>

#include "brim/body/restless.h"
#include "brim/world/islands.h"

namespace brim {

namespace {

/// First number of sleep in memory; differs from those of rows and references (ReferencePoses).
constexpr double kMark = -0.5;

bool may_rest(const Body& body) {
  const auto* restless = dynamic_cast<const Restless*>(&body);
  return !body.immobile() && !(restless != nullptr && restless->restless());
}

}  // namespace

void Sleep::start(std::span<const std::unique_ptr<Body>> bodies) {
  body_.clear();
  for (const auto& b : bodies) body_.push_back(b.get());
  rest_.assign(bodies.size(), 0.0);
  island_.assign(bodies.size(), -1);
}

void Sleep::follow(std::span<const std::unique_ptr<Body>> bodies) {
  if (!on()) return;
  body_.resize(bodies.size());
  rest_.resize(bodies.size(), 0.0);
  island_.resize(bodies.size(), -1);
  for (std::size_t b = 0; b < bodies.size(); ++b) body_[b] = bodies[b].get();
}

int Sleep::count() const {
  return static_cast<int>(std::count_if(island_.begin(), island_.end(), [](std::int32_t i) { return i >= 0; }));
}

void Sleep::take(std::vector<double>& memory) {
  std::fill(rest_.begin(), rest_.end(), 0.0);
  std::fill(island_.begin(), island_.end(), -1);
  if (memory.size() < 2 || memory[0] != kMark) return;
  const auto n = static_cast<std::size_t>(std::clamp(memory[1], 0.0, 0.5 * static_cast<double>(memory.size() - 2)));
  for (std::size_t b = 0; b < std::min(n, rest_.size()); ++b) {
    rest_[b] = memory[2 + 2 * b];
    const double island = memory[3 + 2 * b];
    if (island >= 0.0 && island < static_cast<double>(rest_.size()) && may_rest(*body_[b]))
      island_[b] = static_cast<std::int32_t>(island);
  }
  memory.erase(memory.begin(), memory.begin() + static_cast<std::ptrdiff_t>(2 + 2 * n));
}

void Sleep::keep(std::vector<double>& memory) const {
  if (std::all_of(rest_.begin(), rest_.end(), [](double r) { return r == 0.0; })) return;
  std::vector<double> head = {kMark, static_cast<double>(rest_.size())};
  for (std::size_t b = 0; b < rest_.size(); ++b) head.push_back(rest_[b]), head.push_back(island_[b]);
  memory.insert(memory.begin(), head.begin(), head.end());
}

bool Sleep::wake(std::size_t body) {
  if (!asleep(body)) return false;
  const std::int32_t island = island_[body];
  for (std::size_t b = 0; b < island_.size(); ++b)
    if (island_[b] == island) island_[b] = -1, rest_[b] = 0.0;
  return true;
}

void Sleep::mark(std::span<WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v) const {
  for (WorldPart& p : parts) {
    const auto b = static_cast<std::size_t>(p.body_index);
    const auto vb = v.subspan(first_v[b], first_v[b + 1] - first_v[b]);
    p.still = asleep(b) || (is_fixed(p) && std::all_of(vb.begin(), vb.end(), [](double x) { return x == 0.0; }));
  }
}

void Sleep::settle(std::span<const WorldPart> parts, std::span<const PairReport> pairs, double dt,
                   std::span<const std::uint8_t> held, const std::function<bool(std::size_t)>& driven,
                   std::span<double> v, std::span<const std::size_t> first_v) {
  const std::size_t n = body_.size();
  std::vector<std::uint8_t> stirs(n, 0), parted(n, 0), fixed(n, 0);
  for (const WorldPart& p : parts) {
    const auto b = static_cast<std::size_t>(p.body_index);
    if (!(speed_bound(p, velocities_of(p, v, first_v)) * kRest <= kStir * p.h)) stirs[b] = 1;
    parted[b] = 1;
    fixed[b] = is_fixed(p);
  }
  // Tolerance for the rounding of summed time steps.
  const double enough = kRest - 0.5 * dt;
  for (std::size_t b = 0; b < n; ++b)
    if (!asleep(b)) {
      const bool rests = parted[b] && !fixed[b] && !stirs[b] && !held[b] && may_rest(*body_[b]);
      rest_[b] = rests ? rest_[b] + dt : 0.0;
      if (rest_[b] >= enough && driven(b)) rest_[b] = 0.0;
    }

  // Islands of awake bodies, named by their first body.
  Islands islands(n);
  for (const PairReport& p : pairs) {
    const std::int32_t a = parts[p.part_a].body_index, b = parts[p.part_b].body_index;
    if (!fixed[a] && !fixed[b]) islands.join(a, b);
  }
  std::vector<std::uint8_t> rests(n, 1);
  for (std::size_t b = 0; b < n; ++b)
    if (rest_[b] < enough) rests[islands.first_of(static_cast<std::int32_t>(b))] = 0;
  for (std::size_t b = 0; b < n; ++b) {
    const std::int32_t island = islands.first_of(static_cast<std::int32_t>(b));
    if (asleep(b) || fixed[b] || body_[b]->immobile() || !rests[island]) continue;
    island_[b] = island;
    std::fill(v.begin() + static_cast<std::ptrdiff_t>(first_v[b]),
              v.begin() + static_cast<std::ptrdiff_t>(first_v[b + 1]), 0.0);
  }
}

}  // namespace brim
