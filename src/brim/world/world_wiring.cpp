#include "brim/core/error.h"
#include "brim/world/applied_force.h"
#include "brim/world/attachment.h"
#include "brim/world/space.h"
#include "brim/world/world_impl.h"

namespace brim {

void World::Impl::show_space() {
  append(std::make_unique<Space>(), {}, {});
  has_space = true;
  started = false;
}

void World::Impl::hide_space() {
  bodies.pop_back(), parts.pop_back(), first_q.pop_back(), first_v.pop_back();
  has_space = false;
}

int World::Impl::find(const std::string& name) const {
  for (std::size_t b = 0; b < count(); ++b)
    if (own(b).name() == name) {
      if (out(b)) throw InputError(fmt::format("\"{}\" was removed", name));
      return static_cast<int>(b);
    }
  // Of a repeated body each copy has a name of its own.
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
  for (const int body : {a, b})
    if (body >= 0) wake(body);
  return number;
}

int World::attachment_count() const { return static_cast<int>(impl_->links.size()); }

const Attachment& World::attachment(int i) const {
  Impl& w = *impl_;
  w.update_bodies();
  w.links.find_ends(static_cast<std::size_t>(i), w.parts, w.state.q, w.first_q, w.state.time);
  return w.links.attachment(static_cast<std::size_t>(i));
}

bool World::detached(int i) const { return impl_->links.broken(static_cast<std::size_t>(i)); }

void World::detach(int i) {
  Impl& w = *impl_;
  w.take_memory();
  w.links.set_broken(static_cast<std::size_t>(i), true);
  w.keep_memory();
  const auto [a, b] = w.links.bodies(static_cast<std::size_t>(i));
  for (const int body : {a, b})
    if (body >= 0) wake(body);
}

void World::set_drive(int i, double position, double velocity) {
  impl_->links.set_drive(static_cast<std::size_t>(i), position, velocity);
  wake(impl_->links.bodies(static_cast<std::size_t>(i)).first);
}

int World::apply(const AppliedForce& force) {
  Impl& w = *impl_;
  w.start();
  w.update_bodies();
  const int number = w.actions.add(force, w.bodies, w.parts, w.state.q, w.first_q, w.options.ramp_voxels);
  for (std::size_t b = 0; b < w.count(); ++b) wake(static_cast<int>(b));
  return number;
}

}  // namespace brim
