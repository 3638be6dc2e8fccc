#include "brim/body/meshless/meshless_body.h"

#include <algorithm>
#include <cmath>

#include "brim/core/error.h"

namespace brim {

namespace {

/// Reach of shape functions on a cubic lattice, in spacings: 14 to 27 frames see a point.
constexpr double kFrameReach = 1.75;
/// Matter is tied to frames that hold it as by a layer of itself that is so thick, in spacings.
constexpr double kTieLayer = 0.2;

/// Calls f(center) for the cells of a cubic lattice that covers the box.
template <class F>
void for_cells(const Aabb& box, double cell, const F& f) {
  const Vec3i n = (box.extent() / cell).array().ceil().cast<int>().matrix() + Vec3i::Constant(2);
  const Vec3 lo = box.center() - 0.5 * cell * (n - Vec3i::Ones()).cast<double>();
  for (int k = 0; k < n.z(); ++k)
    for (int j = 0; j < n.y(); ++j)
      for (int i = 0; i < n.x(); ++i) f(Vec3(lo + cell * Vec3(i, j, k)));
}

/// Matter of a cell from the distance at 2x2x2 points in it, linear over half a cell: a share in [0, 1].
double share_of(const std::function<double(const Vec3&)>& distance, const Vec3& center, double cell) {
  const double d = distance(center);
  if (d > cell) return 0.0;
  if (d < -cell) return 1.0;
  double sum = 0.0;
  for (int c = 0; c < 8; ++c) {
    const Vec3 at = center + 0.25 * cell * Vec3((c & 1) != 0 ? 1 : -1, (c & 2) != 0 ? 1 : -1, (c & 4) != 0 ? 1 : -1);
    sum += std::clamp(0.5 - distance(at) / (0.5 * cell), 0.0, 1.0);
  }
  return sum / 8.0;
}

}  // namespace

MeshlessModel fill_with_frames(const std::function<double(const Vec3&)>& distance, const Aabb& box, double spacing,
                               double cell) {
  if (!(spacing > 0.0) || !(cell > 0.0) || !std::isfinite(spacing))
    throw InputError(fmt::format("meshless: a spacing of {} m is not allowed; must be positive and finite", spacing));
  MeshlessModel m;
  m.reach = kFrameReach * spacing;
  for_cells(box, spacing, [&](const Vec3& x) {
    if (distance(x) < 0.5 * spacing) m.frames.push_back(x);
  });
  const auto add = [&](double edge, std::vector<Vec3>& points, std::vector<double>& volumes) {
    for_cells(box, edge, [&](const Vec3& x) {
      const double share = share_of(distance, x, edge);
      if (share < 1.0 / 64.0) return;
      points.push_back(x);
      volumes.push_back(share * edge * edge * edge);
    });
  };
  add(0.5 * spacing, m.samples, m.sample_volume);
  add(cell, m.particles, m.particle_volume);
  if (m.frames.size() < 4 || m.particles.empty())
    throw InputError(
        fmt::format("meshless: a spacing of {:.3g} m leaves {} frames in the solid; there must be four or more",
                    spacing, m.frames.size()));
  return m;
}

MeshlessBody::Parts MeshlessBody::build(const MeshlessModel& m, const Quat& rotation, const Vec3& position,
                                        const ElasticOptions& o, std::span<const HeldRegion> held) {
  require_positive("meshless", "density", o.density);
  require_positive("meshless", "Young's modulus", o.young);
  require_positive("meshless", "reach", m.reach);
  if (!(o.poisson > -1.0 && o.poisson < 0.5))
    throw InputError(fmt::format("meshless: Poisson's ratio is {}; it must be between -1 and 0.5", o.poisson));
  BRIM_CHECK(m.samples.size(), ==, m.sample_volume.size());
  BRIM_CHECK(m.particles.size(), ==, m.particle_volume.size());
  const auto placed = [&](std::vector<Vec3> x) {
    for (Vec3& p : x) p = position + rotation * p;
    return x;
  };
  Parts parts;
  parts.frames = placed(m.frames);
  // Frames that hold no matter of their own (outside of a corner) would have no mass.
  std::vector<Vec3> particles = placed(m.particles);
  for (;;) {
    ShapeFunctions f = moving_least_squares(parts.frames, particles, m.reach);
    parts.carriage = Carriage{std::move(f.rows), std::move(f.gradient), m.particle_volume, m.particle_volume, 0.0};
    for (double& mass : parts.carriage.mass) mass *= o.density;
    const std::vector<double> mass = CarriedVolume::node_masses(parts.carriage, parts.frames.size());
    double mean = 0.0;
    for (const double x : mass) mean += x / static_cast<double>(mass.size());
    std::vector<Vec3> kept;
    for (std::size_t k = 0; k < mass.size(); ++k)
      if (mass[k] > 0.02 * mean) kept.push_back(parts.frames[k]);
    if (kept.size() == parts.frames.size()) break;
    parts.frames = std::move(kept);
    if (parts.frames.size() < 4) throw InputError("meshless: fewer than four frames hold matter");
  }
  const std::vector<Vec3> samples = placed(m.samples);
  parts.shape = moving_least_squares(parts.frames, samples, m.reach);
  parts.volume = m.sample_volume;
  const double layer = kTieLayer / kFrameReach * m.reach;
  parts.held = HeldMatter(held, parts.frames, m.reach, samples, parts.shape, parts.volume, o.young / (layer * layer));
  parts.surface.triangles = m.surface.triangles;
  parts.surface.weights = moving_least_squares(parts.frames, placed(m.surface.vertices), m.reach).rows;
  return parts;
}

MeshlessBody::MeshlessBody(const MeshlessModel& model, const Quat& rotation, const Vec3& position,
                           ElasticOptions options, std::span<const HeldRegion> held)
    : MeshlessBody(build(model, rotation, position, options, held), options) {}

MeshlessBody::MeshlessBody(Parts parts, const ElasticOptions& options)
    : CarriedBody(parts.frames, std::move(parts.carriage), options.weights, std::move(parts.surface), options.young,
                  options),
      elements_(std::move(parts.shape), std::move(parts.volume),
                options.neo_hookean ? ElasticLaw::StableNeoHookean : ElasticLaw::CorotationalLinear,
                Lame::from(options.young, options.poisson), rest_),
      held_(std::move(parts.held)) {
  stiffness_.begin(particle_count());
  elements_.add_pattern(stiffness_);
  held_.add_pattern(stiffness_);
  stiffness_.finish();
  elements_.find_pairs(stiffness_);
  held_.find_pairs(stiffness_);
  force_.assign(particle_count(), Vec3::Zero());
}

}  // namespace brim
