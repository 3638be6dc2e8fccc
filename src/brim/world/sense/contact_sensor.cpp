#include "brim/world/sense/contact_sensor.h"

#include <algorithm>

#include "brim/world/world.h"

namespace brim {

namespace {

/// Count of numbers per pair in memory.
constexpr std::size_t kPairNumbers = 8;
/// Tolerance of a pause's end, relative to a sub-step: times are sums of sub-steps.
constexpr double kTimeSlack = 1e-6;

}  // namespace

ContactSensor::ContactSensor(const SensorModel& model, const World& world)
    : Sensor(model), selection_(model_, world), now_(world.state().time) {
  channels_ = {{"touching", "", Taking::Last},
               {"began", "", Taking::Sum},
               {"ended", "", Taking::Sum},
               {"duration", "s", Taking::Last}};
  add_axes(channels_, "impulse", "N s", Taking::Sum);
  channels_.push_back({"normal_impulse", "N s", Taking::Sum});
  channels_.push_back({"peak", "N", Taking::Largest});
  find_bodies(world);
}

void ContactSensor::find_bodies(const World& world) {
  selection_.find_bodies(world);
  // Pairs keep their bodies under any numbering; contacts of a removed body end unreported.
  std::vector<const Body*> now;
  for (int b = 0; b < world.body_count(); ++b) now.push_back(&world.body(b));
  if (now == bodies_) return;
  std::map<std::pair<int, int>, Touch> kept;
  const auto number = [&](int old) {
    const auto at = std::ranges::find(now, bodies_[static_cast<std::size_t>(old)]);
    return at == now.end() ? -1 : static_cast<int>(at - now.begin());
  };
  for (const auto& [pair, touch] : touching_) {
    const int a = number(pair.first), b = number(pair.second);
    if (a >= 0 && b >= 0) kept[{a, b}] = touch;
  }
  touching_ = std::move(kept);
  bodies_ = std::move(now);
}

void ContactSensor::begin_step(const World&) {
  began_ = ended_ = 0;
  impulse_.setZero();
  normal_ = peak_ = 0.0;
}

void ContactSensor::end(const std::pair<int, int>& pair, const Touch& t, std::vector<ContactEvent>& events) {
  ++ended_;
  events.push_back({0, false, t.until, pair.first, pair.second, t.until - t.since, t.impulse, t.peak});
}

void ContactSensor::substep(const SensedContacts& contacts, std::vector<ContactEvent>& events) {
  selection_.moved();
  load_.clear();
  for (const ContactSample& s : contacts.samples) {
    const ContactSelection::Side side = selection_.side(s);
    if (side.sign == 0.0) continue;
    // Two bodies of the sensor form one pair, in either order of the sample.
    const bool swap = side.within && side.body_b < side.body_a;
    const auto pair = swap ? std::pair(side.body_b, side.body_a) : std::pair(side.body_a, side.body_b);
    Load& load = load_[pair];
    load.normal += s.force.cast<double>().norm();
    load.force += (swap ? -side.sign : side.sign) * (s.force + s.friction).cast<double>();
  }
  now_ = contacts.time + contacts.dt;
  double total = 0.0;
  for (const auto& [pair, load] : load_) {
    total += load.normal;
    const Vec3 impulse = contacts.dt * load.force;
    impulse_ += impulse;
    normal_ += contacts.dt * load.normal;
    if (!(load.normal > model_.least_force)) continue;
    Touch& t = touching_[pair];
    if (t.peak == 0.0) {
      t.since = contacts.time;
      ++began_;
      events.push_back({0, true, t.since, pair.first, pair.second, 0.0, Vec3::Zero(), 0.0});
    }
    t.until = now_;
    t.impulse += impulse;
    t.peak = std::max(t.peak, load.normal);
  }
  peak_ = std::max(peak_, total);
  for (auto at = touching_.begin(); at != touching_.end();) {
    const bool over = now_ - at->second.until > model_.gap + kTimeSlack * contacts.dt;
    if (over) end(at->first, at->second, events);
    at = over ? touching_.erase(at) : std::next(at);
  }
}

void ContactSensor::read(const World&, const StepReport&, std::span<double> values, std::span<double>) {
  double longest = 0.0;
  for (const auto& [pair, t] : touching_) longest = std::max(longest, now_ - t.since);
  const double all[] = {static_cast<double>(touching_.size()),
                        static_cast<double>(began_),
                        static_cast<double>(ended_),
                        longest,
                        impulse_.x(),
                        impulse_.y(),
                        impulse_.z(),
                        normal_,
                        peak_};
  std::copy(std::begin(all), std::end(all), values.begin());
}

void ContactSensor::keep(std::vector<double>& memory) const {
  for (const auto& [pair, t] : touching_) {
    const double numbers[kPairNumbers] = {static_cast<double>(pair.first),
                                          static_cast<double>(pair.second),
                                          t.since,
                                          t.until,
                                          t.impulse.x(),
                                          t.impulse.y(),
                                          t.impulse.z(),
                                          t.peak};
    memory.insert(memory.end(), std::begin(numbers), std::end(numbers));
  }
}

void ContactSensor::take(std::span<const double> memory) {
  touching_.clear();
  for (std::size_t i = 0; i + kPairNumbers <= memory.size(); i += kPairNumbers) {
    const double a = memory[i], b = memory[i + 1], most = static_cast<double>(bodies_.size());
    if (!(a >= 0.0 && a < most && b >= 0.0 && b < most)) continue;
    touching_[{static_cast<int>(a), static_cast<int>(b)}] = {
        memory[i + 2], memory[i + 3], Vec3(memory[i + 4], memory[i + 5], memory[i + 6]), memory[i + 7]};
  }
}

}  // namespace brim
