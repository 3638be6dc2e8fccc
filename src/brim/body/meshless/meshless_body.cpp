#include "brim/body/meshless/meshless_body.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

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

/// Matter of a cell.
struct Share {
  double share = 0.0;  ///< of the cell, 0 to 1
  Vec3 middle;         ///< [m] of the matter
};

/// From the distance at 2x2x2 points in the cell, linear over half a cell.
Share share_of(const std::function<double(const Vec3&)>& distance, const Vec3& center, double cell) {
  const double d = distance(center), quarter = 0.25 * cell;
  if (d > cell) return {0.0, center};
  if (d < -cell) return {1.0, center};
  std::array<double, 8> eighth{};
  const auto corner = [](std::size_t c) {
    return Vec3((c & 1) != 0 ? 1 : -1, (c & 2) != 0 ? 1 : -1, (c & 4) != 0 ? 1 : -1);
  };
  Vec3 away = Vec3::Zero();
  for (std::size_t c = 0; c < 8; ++c) {
    const double at = distance(center + quarter * corner(c));
    eighth[c] = std::clamp(0.5 - at / (2.0 * quarter), 0.0, 1.0);
    away += at / (8.0 * quarter) * corner(c);
  }
  double sum = 0.0;
  Vec3 moment = Vec3::Zero();
  for (std::size_t c = 0; c < 8; ++c) {
    sum += eighth[c];
    // What is missing of an eighth lies outside of the surface.
    moment += eighth[c] * quarter * (corner(c) - (1.0 - eighth[c]) * away);
  }
  return {sum / 8.0, sum > 0.0 ? Vec3(center + moment / sum) : center};
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
  const auto for_matter = [&](double edge, const auto& f) {
    for_cells(box, edge, [&](const Vec3& x) {
      if (const Share s = share_of(distance, x, edge); s.share >= 1.0 / 64.0) f(x, s, s.share * edge * edge * edge);
    });
  };
  for_matter(0.5 * spacing, [&](const Vec3& x, const Share&, double volume) {
    m.samples.push_back(x), m.sample_volume.push_back(volume);
  });
  // Where its matter is: at the middle of a cell that a face cuts in two it would lie on the face, and the density of
  // the layer reach out by a quarter of a voxel.
  for_matter(cell, [&](const Vec3&, const Share& s, double volume) {
    m.particles.push_back(s.middle), m.particle_volume.push_back(volume);
  });
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

StressField MeshlessBody::stress_field() const {
  const std::size_t n = elements_.size();
  const auto volume = elements_.volume();
  StressField out{std::vector<Vec3>(n), {}, {volume.begin(), volume.end()}, {}, std::vector<Mat3>(n),
                  std::vector<Mat3>(n)};
  const WeightRows& rows = elements_.shape().rows;
  parallel_for(
      n,
      [&](std::size_t s) {
        out.place[s].setZero();
        for (auto e = static_cast<std::size_t>(rows.first[s]); e < static_cast<std::size_t>(rows.first[s + 1]); ++e)
          out.place[s] += rows.weight[e] * x_[static_cast<std::size_t>(rows.source[e])];
        out.deformation[s] = elements_.deformation(s, x_);
        out.stress[s] = cauchy_stress(elements_.stress(s, x_), out.deformation[s]);
      },
      256);
  return out;
}

void MeshlessBody::show(std::span<const double> value, std::span<float> out) const {
  BRIM_CHECK(value.size(), ==, elements_.size());
  const WeightRows& rows = elements_.shape().rows;
  std::vector<double> sum(particle_count(), 0.0), matter(particle_count(), 0.0);
  for (std::size_t s = 0; s < value.size(); ++s)
    for (auto e = static_cast<std::size_t>(rows.first[s]); e < static_cast<std::size_t>(rows.first[s + 1]); ++e) {
      const double share = std::abs(rows.weight[e]) * elements_.volume()[s];
      sum[static_cast<std::size_t>(rows.source[e])] += share * value[s];
      matter[static_cast<std::size_t>(rows.source[e])] += share;
    }
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = matter[k] > 0.0 ? sum[k] / matter[k] : 0.0;
  show_nodes(sum, out);
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
