#include "brim/world/start_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "brim/body/changing_surface.h"
#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/core/error.h"

namespace brim {

namespace {

/// Cell (x, y, z) as one number; cells 2^21 apart share one, which only costs time.
std::uint64_t cell_key(const Vec3i& c) {
  const auto bits = [](int i) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(i)) & 0x1fffffu; };
  return bits(c.x()) | bits(c.y()) << 21 | bits(c.z()) << 42;
}

Vec3i cell_of(const Vec3& x, double side) { return (x / side).array().floor().cast<int>(); }

}  // namespace

StartPlaces::StartPlaces(const Body& body) : body_(body) {
  for (int p = 0; p < body.part_count(); ++p)
    if (const PosedShape* solid = solid_of(body, p)) pose_.push_back(solid->pose());
  if (static_cast<int>(pose_.size()) == body.part_count()) return;
  pose_.clear();
  if (changing_surface(body) != nullptr || body.display().vertices == 0)
    throw InputError(fmt::format("'{}' ({}) carries no region along", body.name(), body.kind()));
  display_now(body, start_);
  Aabb box;
  for (const Vec3f& x : start_) box.extend(x.cast<double>());
  // About one cell per vertex if they lie on a surface.
  cell_ = std::max(box.extent().norm() / std::sqrt(static_cast<double>(start_.size())), 1e-9);
}

void StartPlaces::sort_vertices() {
  display_now(body_, now_);
  vertices_.clear();
  for (std::size_t i = 0; i < now_.size(); ++i)
    vertices_[cell_key(cell_of(now_[i].cast<double>(), cell_))].push_back(static_cast<std::int32_t>(i));
  known_ = true;
}

Vec3 StartPlaces::of(int part, const Vec3& x) {
  if (!pose_.empty()) {
    const Pose& start = pose_[static_cast<std::size_t>(part)];
    return start.translation + start.rotation * solid_of(body_, part)->pose().to_local(x);
  }
  if (!known_) sort_vertices();
  const Vec3i middle = cell_of(x, cell_);
  double least = std::numeric_limits<double>::infinity();
  std::int32_t best = -1;
  const auto look = [&](std::int32_t i) {
    const double d = (now_[static_cast<std::size_t>(i)].cast<double>() - x).squaredNorm();
    if (d < least || (d == least && i < best)) least = d, best = i;
  };
  // Search rings of cells outwards, until no farther ring can contain a nearer vertex.
  constexpr int kRings = 4;
  for (int ring = 0; ring <= kRings + 1 && !(least <= std::pow((ring - 1) * cell_, 2)); ++ring)
    for (int k = -ring; k <= ring; ++k)
      for (int j = -ring; j <= ring; ++j)
        for (int i = -ring; i <= ring; ++i) {
          if (std::max({std::abs(i), std::abs(j), std::abs(k)}) != ring) continue;
          const auto cell = vertices_.find(cell_key(middle + Vec3i(i, j, k)));
          if (cell != vertices_.end()) std::for_each(cell->second.begin(), cell->second.end(), look);
        }
  if (!(least <= std::pow(kRings * cell_, 2)))
    for (std::size_t i = 0; i < now_.size(); ++i) look(static_cast<std::int32_t>(i));
  return start_[static_cast<std::size_t>(best)].cast<double>();
}

}  // namespace brim
