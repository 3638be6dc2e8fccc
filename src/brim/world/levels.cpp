#include "brim/world/levels.h"

#include <algorithm>
#include <cmath>

#include "brim/core/error.h"

namespace brim {

namespace {

/// First number of levels in memory; differs from those of sleep, rows and references.
constexpr double kLevelsMark = -0.25;
constexpr int kMostLevel = 8;

/// Share of the budget below which levels get finer again: one level less costs up to four times as much.
constexpr double kFinerBelow = 0.25;
/// Hysteresis: a level chosen by distance is left only a tenth beyond the distance at which it began.
constexpr double kPast = 1.1;

int level_at(double distance, double near, int most) {
  if (!(distance >= near)) return 0;
  return std::clamp(1 + static_cast<int>(std::floor(std::log2(distance / near))), 0, most);
}

/// "gear" for gear.0, gear.1, ...
std::string stem(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  return dot == std::string::npos ? name : name.substr(0, dot);
}

/// Count of numbers in memory before those of the bodies.
constexpr std::size_t kNumbers = 14;

}  // namespace

std::size_t Levels::read(std::span<const double> memory) {
  fixed_.clear(), level_.clear(), changed_.clear();
  shift_ = {};
  if (memory.size() < kNumbers || memory[0] != kLevelsMark || memory[1] < kNumbers - 2) return 0;
  const auto size = static_cast<std::size_t>(std::clamp(memory[1], 0.0, static_cast<double>(memory.size() - 2))) + 2;
  const auto whole = [&](std::size_t i, double most) { return static_cast<int>(std::clamp(memory[i], -1.0, most)); };
  const auto n = static_cast<std::size_t>(std::clamp(memory[2], 0.0, static_cast<double>(size)));
  if (kNumbers + 3 * n > size) return size;
  options_ = {};
  options_.interval = std::max(1, whole(3, 1e9));
  options_.average = memory[4] != 0.0;
  options_.most = std::max(0, whole(5, kMostLevel));
  options_.budget = std::max(0.0, memory[6]);
  if (memory[7] != 0.0) options_.interest = Vec3(memory[8], memory[9], memory[10]);
  options_.near = std::max(1e-300, memory[11]);
  bias_ = std::max(0, whole(12, kMostLevel));
  told_ = memory[13] != 0.0;
  for (std::size_t b = 0; b < n; ++b) {
    fixed_.push_back(whole(kNumbers + 3 * b, kMostLevel));
    level_.push_back(std::max(0, whole(kNumbers + 3 * b + 1, kMostLevel)));
    changed_.push_back(std::max(0, whole(kNumbers + 3 * b + 2, kMostLevel)));
  }
  shift_.take(memory.subspan(kNumbers + 3 * n, size - kNumbers - 3 * n));
  return size;
}

void Levels::take(std::vector<double>& memory, std::span<const std::unique_ptr<Body>> bodies) {
  const std::size_t size = read(memory);
  memory.erase(memory.begin(), memory.begin() + static_cast<std::ptrdiff_t>(size));
  if (level_.size() != bodies.size()) fixed_.clear(), level_.clear(), changed_.clear(), shift_ = {};
}

void Levels::keep(std::vector<double>& memory) const {
  if (!on()) return;
  const Vec3 p = options_.interest.value_or(Vec3::Zero());
  std::vector<double> head = {kLevelsMark,
                              0.0,
                              static_cast<double>(level_.size()),
                              static_cast<double>(options_.interval),
                              options_.average ? 1.0 : 0.0,
                              static_cast<double>(options_.most),
                              options_.budget,
                              options_.interest ? 1.0 : 0.0,
                              p.x(),
                              p.y(),
                              p.z(),
                              options_.near,
                              static_cast<double>(bias_),
                              told_ ? 1.0 : 0.0};
  for (std::size_t b = 0; b < level_.size(); ++b)
    for (const int x : {fixed_[b], level_[b], changed_[b]}) head.push_back(x);
  const std::vector<double> shifts = shift_.numbers();
  head.insert(head.end(), shifts.begin(), shifts.end());
  head[1] = static_cast<double>(head.size() - 2);
  memory.insert(memory.begin(), head.begin(), head.end());
}

void set_levels(World& world, const LevelOptions& options) {
  const auto need = [](const char* what, double value, bool good) {
    if (!good) throw InputError(fmt::format("levels: {} = {} is out of range", what, value));
  };
  need("most", options.most, options.most >= 0 && options.most <= kMostLevel);
  need("near [m]", options.near, options.near > 0.0 && std::isfinite(options.near));
  need("budget [s]", options.budget, options.budget >= 0.0 && std::isfinite(options.budget));
  need("interval", options.interval, options.interval >= 1);
  Levels levels;
  levels.options_ = options;
  for (int b = 0; b < world.body_count(); ++b) {
    const std::string& name = world.body(b).name();
    auto it = options.bodies.find(name);
    if (it == options.bodies.end()) it = options.bodies.find(stem(name));
    levels.fixed_.push_back(it != options.bodies.end() ? it->second : -1);
    need("level", levels.fixed_.back(), levels.fixed_.back() >= -1 && levels.fixed_.back() <= kMostLevel);
    levels.level_.push_back(std::max(0, levels.fixed_.back()));
  }
  levels.changed_ = levels.level_;
  State state = world.state();
  state.warm_start.erase(state.warm_start.begin(),
                         state.warm_start.begin() + static_cast<std::ptrdiff_t>(Levels().read(state.warm_start)));
  levels.keep(state.warm_start);
  world.set_state(std::move(state));
}

void follow_levels(World& world, std::span<const int> followed) {
  State state = world.state();
  Levels levels;
  const std::size_t size = levels.read(state.warm_start);
  if (followed.size() != levels.level_.size())
    throw InputError(fmt::format("levels: {} are given; this world has {} bodies whose level is known", followed.size(),
                                 levels.level_.size()));
  state.warm_start.erase(state.warm_start.begin(), state.warm_start.begin() + static_cast<std::ptrdiff_t>(size));
  levels.told_ = true;
  levels.changed_.assign(followed.begin(), followed.end());
  levels.keep(state.warm_start);
  world.set_state(std::move(state));
}

std::vector<int> levels_in(const State& state) {
  Levels levels;
  levels.read(state.warm_start);
  return levels.level_;
}

bool Levels::choose(std::int64_t step, std::span<const std::unique_ptr<Body>> bodies) {
  const std::vector<int> before = level_;
  if (told_) {
    told_ = false;
    level_ = changed_;
    return level_ != before;
  }
  if (step % options_.interval != 0) return false;
  if (options_.budget > 0.0 && timed_ > 0) {
    const double mean = seconds_ / timed_;
    if (mean > options_.budget && bias_ < options_.most) ++bias_;
    if (mean < kFinerBelow * options_.budget && bias_ > 0) --bias_;
  }
  seconds_ = 0.0, timed_ = 0;
  for (std::size_t b = 0; b < level_.size(); ++b) {
    if (fixed_[b] >= 0) {
      level_[b] = fixed_[b];
    } else if (options_.interest) {
      Aabb box;
      for (int p = 0; p < bodies[b]->part_count(); ++p) box.extend(bodies[b]->bounds(p));
      const Vec3 beyond = (box.lo - *options_.interest).cwiseMax(*options_.interest - box.hi).cwiseMax(0.0);
      const double distance = box.empty() ? 0.0 : beyond.norm(), near = std::ldexp(options_.near, -bias_);
      level_[b] = std::clamp(level_[b], level_at(distance / kPast, near, options_.most),
                             level_at(distance * kPast, near, options_.most));
    } else {
      level_[b] = bias_;
    }
  }
  changed_ = level_;
  return level_ != before;
}

void Levels::mark(std::span<WorldPart> parts) const {
  for (WorldPart& p : parts) p.level = level(static_cast<std::size_t>(p.body_index));
}

}  // namespace brim
