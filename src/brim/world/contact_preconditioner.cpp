#include "brim/world/contact_preconditioner.h"

#include <algorithm>
#include <map>

#include "brim/core/parallel.h"
#include "brim/core/profile.h"

namespace brim {

namespace {

std::size_t count_acting(std::span<const std::uint8_t> acting) {
  return static_cast<std::size_t>(std::ranges::count_if(acting, [](std::uint8_t a) { return a != 0; }));
}

std::size_t may_differ(std::size_t acting) {
  return std::min(ContactPreconditioner::kMayDiffer, acting / ContactPreconditioner::kFew);
}

/// Number of contacts of the rows that are active.
std::size_t count_held(const ContactRows& rows, std::span<const std::uint8_t> acting) {
  return static_cast<std::size_t>(std::ranges::count_if(rows.contact, [&](std::uint32_t c) { return acting[c] != 0; }));
}

}  // namespace

std::size_t count_changed(const ContactRows& rows, std::span<const std::uint8_t> acting,
                          const std::function<Mat3(std::size_t)>& block) {
  std::size_t changed = count_acting(acting) - count_held(rows, acting);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::uint32_t c = rows.contact[i];
    const Eigen::Matrix3f& was = rows.stiffness[i];
    Eigen::Matrix3f now = Eigen::Matrix3f::Zero();
    if (acting[c] != 0) now = block(c).cast<float>();
    changed += (now - was).squaredNorm() > std::min(now.squaredNorm(), was.squaredNorm());
  }
  return changed;
}

void ContactPreconditioner::begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                                  const BlockDiagonal& diagonal, std::span<const std::size_t> first_block,
                                  std::span<const std::uint8_t> sparse, std::span<const std::int32_t> island,
                                  std::span<const std::uint8_t> asleep) {
  factor_.begin(bodies, first_v, diagonal, first_block, sparse, island);
  std::map<std::int32_t, std::vector<CoarseGrid::Member>> members;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b]->immobile() || (!asleep.empty() && asleep[b])) continue;
    if (first_v[b + 1] - first_v[b] < 3 * kLarge || !sparse[b]) continue;
    if (const auto system = bodies[b]->block_system(); system && !system->place.empty())
      members[island[b]].push_back({first_v[b], *system});
  }
  const ProfileScope scope("coarse grid, made");
  grids_.resize(members.size());
  std::size_t g = 0;
  for (const auto& [_, list] : members) grids_[g++].begin(list, first_v.back());
}

void ContactPreconditioner::apply(std::span<const double> r, std::span<double> z) {
  {
    const ProfileScope scope("contact factor, applied");
    factor_.apply(r, z);
  }
  if (grids_.empty() || factor_.complete()) return;
  const ProfileScope scope("coarse grid, applied");
  for (CoarseGrid& grid : grids_) grid.add(r, z);
}

void ContactPreconditioner::reserve(const ContactMaps& all) {
  all.gather_rows(rows_);
  factor_.reserve(rows_);
}

void ContactPreconditioner::make(const ContactMaps& acting, const Penalty& response, bool first,
                                 const std::function<void()>& beside) {
  // Released contacts stay as rows without stiffness, and a few new ones are left out: the touched blocks stay.
  const std::size_t acting_now = count_acting(response.acting());
  const bool known = !first && acting_now - count_held(rows_, response.acting()) <= may_differ(acting_now);
  if (!known) {
    const ProfileScope scope("contact rows");
    acting.gather_rows(rows_);
  }
  make_factor(response, known, beside);
  if (grids_.empty() || factor_.complete()) return;
  const ProfileScope scope("coarse grid, factored");
  for (CoarseGrid& grid : grids_) grid.factor(rows_);
}

void ContactPreconditioner::make_factor(const Penalty& response, bool known, const std::function<void()>& beside) {
  const ProfileScope scope("contact factor, made");
  parallel_for(
      rows_.size(), [&](std::size_t i) { rows_.stiffness[i] = response.block(rows_.contact[i]).cast<float>(); }, 512);
  if (known)
    factor_.refactor(rows_, beside);
  else
    factor_.factor(rows_, {}, beside);
  profile_count("blocks that contact touches", static_cast<double>(factor_.touched()));
  profile_count("floats of the contact factor", static_cast<double>(factor_.entries()));
}

bool ContactPreconditioner::serves(const Penalty& response) const {
  const std::size_t changed = count_changed(rows_, response.acting(), [&](std::size_t c) { return response.block(c); });
  return changed <= may_differ(count_acting(response.acting()));
}

}  // namespace brim
