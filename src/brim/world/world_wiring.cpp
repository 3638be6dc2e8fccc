#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "brim/body/aimed_drives.h"
#include "brim/body/kinematic.h"
#include "brim/core/checked_index.h"
#include "brim/core/error.h"
#include "brim/world/applied_force.h"
#include "brim/world/attachment.h"
#include "brim/world/impulse.h"
#include "brim/world/space.h"
#include "brim/world/world_impl.h"

namespace brim {

namespace {

constexpr double kGrabFrequency = 3.0;  ///< [Hz] of a body on the grab spring
constexpr double kGrabReach = 2.0;      ///< [voxels] radius of the material that is held of a deformable body
constexpr std::size_t kListed = 12;     ///< names in a message

std::string listed(std::span<const std::string> names) {
  std::string all;
  for (std::size_t i = 0; i < std::min(names.size(), kListed); ++i) all += (i == 0 ? "\"" : ", \"") + names[i] + "\"";
  return all + (names.size() > kListed ? ", ..." : "");
}

}  // namespace

void World::Impl::show_space() {
  append(std::make_unique<Space>(), {}, {});
  has_space = true;
  if (!started) return;
  // Steps chosen at the start of the world stay.
  part_h.push_back(*std::ranges::max_element(part_h));
  if (sleep.on()) sleep.follow(bodies);
  follow_edits();
  stage.rigid().restore(state.warm_start);
}

void World::Impl::hide_space() {
  bodies.pop_back(), parts.pop_back(), first_q.pop_back(), first_v.pop_back();
  has_space = false;
}

int World::Impl::find(const std::string& name) const {
  for (std::size_t b = 0; b < count(); ++b)
    if (own(b).name() == name) {
      if (is_removed(b)) throw InputError(fmt::format("\"{}\" was removed", name));
      return static_cast<int>(b);
    }
  // Copies of a repeated body have individual names.
  for (std::size_t b = 0; b < count(); ++b)
    if (own(b).name() == name + ".0")
      throw InputError(fmt::format("\"{}\" is repeated; name one of its copies, such as \"{}.0\"", name, name));
  throw InputError(fmt::format("\"{}\" is not a body", name));
}

Links::Side World::Impl::side_of(int body) {
  Links::Side side;
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (parts[p].body_index == body) side.parts.push_back(static_cast<int>(p));
  side.q = q(static_cast<std::size_t>(body));
  return side;
}

void World::Impl::keep_apart() {
  rules.clear_apart();
  for (std::size_t l = 0; l < links.size(); ++l)
    if (const auto [a, b] = links.bodies(l); !links.attachment(l).touch && b >= 0 && !links.broken(l))
      rules.keep_apart(a, b);
}

int World::attach(const Attachment& attachment) {
  Impl& w = *impl_;
  const int a = w.find(attachment.body), b = attachment.to.empty() ? -1 : w.find(attachment.to);
  w.start();
  w.update_bodies();
  const int number = w.links.add(attachment, w.parts, w.side_of(a), b < 0 ? Links::Side{} : w.side_of(b),
                                 w.options.ramp_voxels, w.state.time);
  if (w.links.needs_space() && !w.has_space) w.show_space();
  w.keep_apart();
  w.note_wiring();
  for (const int body : {a, b})
    if (body >= 0) wake(body);
  return number;
}

int World::attachment_count() const { return static_cast<int>(impl_->links.kept()); }

std::size_t World::Impl::link_index(int i, const char* what) const {
  return checked_index(i, links.kept(), what, "attachment");
}

const Attachment& World::attachment(int i) const {
  Impl& w = *impl_;
  const std::size_t link = w.link_index(i, "attachment");
  w.catch_up();
  w.update_bodies();
  w.links.find_ends(link, w.parts, w.state.q, w.first_q, w.state.time);
  return w.links.attachment(link);
}

std::int64_t World::attachment_id(int i) const { return impl_->links.id(impl_->link_index(i, "attachment_id")); }

bool World::detached(int i) const { return impl_->links.broken(impl_->link_index(i, "detached")); }

void World::detach(int i) {
  Impl& w = *impl_;
  const std::size_t link = w.link_index(i, "detach");
  w.take_memory();
  w.links.set_broken(link, true);
  w.keep_memory();
  const auto [a, b] = w.links.bodies(link);
  for (const int body : {a, b})
    if (body >= 0) wake(body);
}

void World::set_drive(int i, double position, double velocity) {
  const std::size_t link = impl_->link_index(i, "set_drive");
  impl_->take_memory();
  try {
    impl_->links.set_drive(link, position, velocity);
  } catch (...) {
    impl_->keep_memory();
    throw;
  }
  impl_->keep_memory();
  wake(impl_->links.bodies(link).first);
}

namespace {

/// @throws InputError  when a body has no drives
const AimedDrives& drives_of(const Body& body) {
  const auto* drives = dynamic_cast<const AimedDrives*>(&body);
  if (drives == nullptr || drives->drive_names().empty())
    throw InputError(fmt::format("set_drive: '{}' ({}) has no drives", body.name(), body.kind()));
  return *drives;
}

}  // namespace

std::span<const std::string> World::drives(int b) const {
  const auto* drives = dynamic_cast<const AimedDrives*>(&body(b));
  return drives == nullptr ? std::span<const std::string>() : drives->drive_names();
}

void World::set_drive(int b, std::string_view joint, double position, double velocity) {
  impl_->need(b, "set_drive");
  const auto names = drives_of(body(b)).drive_names();
  const auto found = std::ranges::find(names, joint);
  if (found == names.end())
    throw InputError(
        fmt::format("set_drive: '{}' has no drive at \"{}\"; its drives are {}", body(b).name(), joint, listed(names)));
  set_drive(b, static_cast<int>(found - names.begin()), position, velocity);
}

void World::set_drive(int b, int drive, double position, double velocity) {
  impl_->need(b, "set_drive");
  const auto names = drives_of(body(b)).drive_names();
  if (drive < 0 || drive >= static_cast<int>(names.size()))
    throw InputError(fmt::format("set_drive: '{}' has no drive {}; it has {}", body(b).name(), drive, names.size()));
  impl_->aim(b, static_cast<std::size_t>(drive), {&position, 1}, {&velocity, 1});
}

void World::set_drives(int b, std::span<const double> position, std::span<const double> velocity) {
  impl_->need(b, "set_drives");
  const auto names = drives_of(body(b)).drive_names();
  const auto need_one_each = [&](const char* what, std::size_t n) {
    if (n == names.size()) return;
    throw InputError(fmt::format("set_drives: {} {} are not allowed for '{}'; its {} drives are {}", n, what,
                                 body(b).name(), names.size(), listed(names)));
  };
  need_one_each("positions", position.size());
  if (!velocity.empty()) need_one_each("velocities", velocity.size());
  impl_->aim(b, 0, position, velocity);
}

std::optional<DriveAim> World::aim(int i) const { return impl_->links.aim(impl_->link_index(i, "aim")); }
std::optional<DriveAim> World::aim(int b, int drive) const {
  checked_index(drive, drives_of(impl_->own(impl_->body_index(b, "aim"))).drive_names().size(), "aim", "drive");
  return impl_->aims.of(b, drive);
}

void World::Impl::aim(int b, std::size_t first, std::span<const double> position, std::span<const double> velocity) {
  const Body& body = own(static_cast<std::size_t>(b));
  const auto joints = drives_of(body).drive_names();
  for (const auto& [what, list] : {std::pair{"position", position}, std::pair{"velocity", velocity}})
    for (std::size_t i = 0; i < list.size(); ++i)
      if (!std::isfinite(list[i]))
        throw InputError(fmt::format("set_drive: {} {} of \"{}\" of '{}' is not allowed; must be finite", what, list[i],
                                     joints[first + i], body.name()));
  take_memory();
  aims.set(b, first, position, velocity, [this](int n) { return aimed(n); });
  if (sleep.on()) sleep.wake(static_cast<std::size_t>(b));
  keep_memory();
}

void World::grab(int b, const Vec3& at, double stiffness, double damping) {
  Impl& w = *impl_;
  w.need(b, "grab");
  const Body& body = this->body(b);
  const auto refuse = [&](const std::string& why) { throw InputError(fmt::format("grab: '{}' {}", body.name(), why)); };
  if (!at.allFinite()) refuse("needs a place of finite numbers");
  for (const auto& [what, value] : {std::pair{"stiffness", stiffness}, std::pair{"damping", damping}})
    if (!(value >= 0.0) || !std::isfinite(value))
      refuse(fmt::format("is not held with {} {}; must be a number from 0", what, value));
  if (body.immobile() || frozen(b)) refuse("does not move");
  w.start();
  w.update_bodies();
  const double m = body.mass(), omega = 2.0 * std::numbers::pi * kGrabFrequency;
  const auto goal = std::make_shared<Vec3>(at);
  Attachment hold;
  hold.name = "grab";
  hold.body = body.name();
  hold.point = at;
  hold.stiffness = stiffness > 0.0 ? stiffness : m * omega * omega;
  hold.damping = damping > 0.0 ? damping : m * omega;
  hold.motion = [goal, at](double, const Vec3& x, const Vec3&) -> Vec3 { return x + (*goal - at); };
  const Links::Side side = w.side_of(b);
  // A deformable body is held by the material around the place, not by one node.
  if (!side.parts.empty() && !MatterPoints::takes_any(w.parts[static_cast<std::size_t>(side.parts[0])])) {
    const double reach = kGrabReach * w.parts[static_cast<std::size_t>(side.parts[0])].h;
    std::vector<Vec3f> shown(body.display().vertices);
    body.display_positions(shown);
    const auto near = [at, reach](const Vec3& x) { return (x - at).norm() < reach; };
    if (std::ranges::any_of(shown, [&](const Vec3f& x) { return near(x.cast<double>()); }))
      hold.point.reset(), hold.region = near;
  }
  w.links.grab(hold, w.parts, side, w.options.ramp_voxels, w.state.time);
  w.grab_goal = goal;
  if (!w.has_space) w.show_space();
  wake(b);
}

void World::pull(const Vec3& to) {
  if (grabbed() < 0) throw InputError("pull: nothing is grabbed");
  if (!to.allFinite()) throw InputError("pull: the place is not finite");
  *impl_->grab_goal = to;
  wake(grabbed());
}

void World::release() {
  const int b = grabbed();
  impl_->links.release();
  if (b >= 0) wake(b);
}

int World::grabbed() const { return impl_->links.grabs() ? impl_->links.bodies(impl_->links.kept()).first : -1; }

int World::apply(const AppliedForce& force) {
  Impl& w = *impl_;
  w.start();
  w.update_bodies();
  const int number = w.actions.add(force, w.bodies, w.parts, w.state.q, w.first_q, w.options.ramp_voxels);
  w.note_wiring();
  w.wake_all();
  return number;
}

void World::remove_force(int i) {
  Impl& w = *impl_;
  OuterActions::List list = w.actions.list();
  list.erase(list.begin() + static_cast<std::ptrdiff_t>(checked_index(i, list.size(), "remove_force", "force")));
  w.actions.set_list(list);
  w.note_wiring();
  w.wake_all();
}

Vec3 World::apply_impulse(int b, const Vec3& impulse, const Vec3& point) {
  Impl& w = *impl_;
  w.need(b, "apply_impulse");
  const Body& body = this->body(b);
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("apply_impulse: '{}' {}", body.name(), why));
  };
  if (!impulse.allFinite() || !point.allFinite()) refuse("needs an impulse and a point of finite numbers");
  if (frozen(b)) refuse("is frozen; let it go first");
  if (body.immobile() || dynamic_cast<const Kinematic*>(&body) != nullptr)
    refuse(fmt::format("({}) does not move by forces", body.kind()));
  w.start();
  w.update_bodies();
  const auto i = static_cast<std::size_t>(b);
  std::vector<WorldPart> mine;
  for (const int p : w.side_of(b).parts) mine.push_back(w.parts[static_cast<std::size_t>(p)]);
  const std::optional<ImpulseEffect> effect = find_impulse_effect(mine, w.options.ramp_voxels, w.q(i), impulse, point);
  if (!effect) refuse(fmt::format("({}) has no points to act on", body.kind()));
  const std::span<double> v = w.v(i);
  std::vector<double> after(v.begin(), v.end());
  for (std::size_t k = 0; k < v.size(); ++k) after[k] += effect->change[k];
  if (!std::ranges::all_of(after, [](double x) { return std::isfinite(x); }))
    refuse("would not have finite velocities; the impulse is too large");
  w.wake(i);
  std::ranges::copy(after, w.v(i).begin());
  w.whole_is_old = true;
  w.update_bodies();
  return effect->point;
}

int World::force_count() const { return static_cast<int>(impl_->actions.size()); }
std::int64_t World::force_id(int i) const {
  return impl_->actions.id(checked_index(i, impl_->actions.size(), "force_id", "force"));
}

}  // namespace brim
