#include "brim/body/volume/soft_image_body.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/areal_mass.h"
#include "brim/mesh/lattice_around.h"
#include "brim/mesh/mass_properties.h"

namespace brim {

namespace {

/// Cells with less than this share of matter are left out. [1/255]
constexpr int kLeastMatter = 4;
/// Least stiffness of a tetrahedron, in that of one full of its matter: corners with little matter stay held.
constexpr double kLeastShare = 0.05;
/// Least stiffness of a sixth of a tetrahedron, in that of the whole.
constexpr double kLeastSixth = 0.01;

/// Rows of barycentric weights.
WeightRows rows_of(const TetMesh& mesh, const Embedding& embedding) {
  WeightRows rows;
  for (std::size_t i = 0; i < embedding.tet.size(); ++i) {
    const Tetrahedron& t = mesh.tets[static_cast<std::size_t>(embedding.tet[i])];
    rows.source.insert(rows.source.end(), t.begin(), t.end());
    rows.weight.insert(rows.weight.end(), embedding.weights[i].begin(), embedding.weights[i].end());
    rows.first.push_back(static_cast<std::int32_t>(rows.source.size()));
  }
  return rows;
}

/// Mean of moduli of matter that is pressed together (Reuss): 1/E = Σ (V/E) / Σ V.
double softness_mean(const std::vector<double>& young, const std::vector<double>& volume) {
  double softness = 0.0, all = 0.0;
  for (std::size_t i = 0; i < young.size(); ++i) softness += volume[i] / young[i], all += volume[i];
  return all / softness;
}

/// Mean over the particles that lie in each tetrahedron, by their volume; of one that holds none, over those of the
/// tetrahedra that touch it. @param tet  that each particle lies in
std::vector<double> element_means(const TetMesh& mesh, const std::vector<std::int32_t>& tet,
                                  const std::vector<double>& value, const std::vector<double>& volume) {
  std::vector<double> sum(mesh.tets.size(), 0.0), weight(sum.size(), 0.0);
  std::vector<double> corner_sum(mesh.vertices.size(), 0.0), corner_weight(mesh.vertices.size(), 0.0);
  double all = 0.0, all_weight = 0.0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    sum[static_cast<std::size_t>(tet[i])] += volume[i] * value[i];
    weight[static_cast<std::size_t>(tet[i])] += volume[i];
    all += volume[i] * value[i], all_weight += volume[i];
  }
  for (std::size_t e = 0; e < sum.size(); ++e)
    for (const std::int32_t c : mesh.tets[e]) {
      corner_sum[static_cast<std::size_t>(c)] += sum[e];
      corner_weight[static_cast<std::size_t>(c)] += weight[e];
    }
  std::vector<double> mean(sum.size());
  for (std::size_t e = 0; e < sum.size(); ++e) {
    double s = sum[e], w = weight[e];
    if (!(w > 0.0))
      for (const std::int32_t c : mesh.tets[e])
        s += corner_sum[static_cast<std::size_t>(c)], w += corner_weight[static_cast<std::size_t>(c)];
    mean[e] = w > 0.0 ? s / w : all / all_weight;
  }
  return mean;
}

double volume_of(const TetMesh& mesh, std::size_t e) {
  const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(mesh.tets[e][k])]; };
  return tet_volume(corner(0), corner(1), corner(2), corner(3));
}

/// Where the matter of a cell lies, [m]: what is missing of it is on the side to which the shares around fall.
Vec3 middle_of_matter(const OccupancyGrid& matter, int i, int j, int k) {
  const auto share = [&](int a, int b, int c) {
    const bool in = a >= 0 && b >= 0 && c >= 0 && a < matter.cells.x() && b < matter.cells.y() && c < matter.cells.z();
    return in ? static_cast<double>(matter.share[matter.index(a, b, c)]) : 0.0;
  };
  const Vec3 inwards(share(i + 1, j, k) - share(i - 1, j, k), share(i, j + 1, k) - share(i, j - 1, k),
                     share(i, j, k + 1) - share(i, j, k - 1));
  const double missing = 1.0 - share(i, j, k) / 255.0, size = inwards.norm();
  return matter.center(i, j, k) + (size > 0.0 ? Vec3(0.5 * missing * matter.spacing / size * inwards) : Vec3::Zero());
}

/// Calls f(place, weight) for the edges of a tetrahedron nearest to a point (EdgeShares); equal ones share it.
/// @param weight  barycentric, of the point
template <class F>
void for_nearest_edges(const std::array<double, 4>& weight, const F& f) {
  EdgeShares sum;
  for (std::size_t i = 0, place = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j, ++place) sum[place] = weight[i] + weight[j];
  const double nearest = *std::max_element(sum.begin(), sum.end()) - 1e-9;
  const auto equal = std::count_if(sum.begin(), sum.end(), [&](double s) { return s > nearest; });
  for (std::size_t place = 0; place < 6; ++place)
    if (sum[place] > nearest) f(place, 1.0 / static_cast<double>(equal));
}

/// Shares of matter in each tetrahedron and its sixths: means over points spread evenly through it, four or more to a
/// cell's width (10 to 16 along an edge), each that of the cell in which it lies. At least kLeastShare.
void matter_shares(const TetMesh& mesh, const OccupancyGrid& matter, double edge, std::vector<double>& share,
                   std::vector<EdgeShares>& sixths) {
  const int n = std::clamp(static_cast<int>(std::ceil(4.0 * edge / matter.spacing)), 10, 16);
  const auto share_at = [&](const Vec3& x) {
    const Vec3i c = ((x - matter.origin) / matter.spacing + Vec3::Constant(0.5)).array().floor().cast<int>().matrix();
    if ((c.array() < 0).any() || (c.array() >= matter.cells.array()).any()) return 0.0;
    return matter.share[matter.index(c.x(), c.y(), c.z())] / 255.0;
  };
  share.resize(mesh.tets.size());
  sixths.resize(mesh.tets.size());
  parallel_for(
      mesh.tets.size(),
      [&](std::size_t e) {
        const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(mesh.tets[e][k])]; };
        const Vec3 x0 = corner(0), a = (corner(1) - x0) / n, b = (corner(2) - x0) / n, c = (corner(3) - x0) / n;
        double sum = 0.0;
        EdgeShares near{};
        int count = 0;
        for (int i = 0; i < n; ++i)
          for (int j = 0; i + j < n; ++j)
            for (int k = 0; i + j + k < n; ++k, ++count) {
              const double s = share_at(x0 + (i + 0.25) * a + (j + 0.25) * b + (k + 0.25) * c);
              sum += s;
              for_nearest_edges({n - i - j - k - 0.75, i + 0.25, j + 0.25, k + 0.25},
                                [&](std::size_t place, double w) { near[place] += w * s; });
            }
        share[e] = std::max(kLeastShare, sum / count);
        // Sixths have the mean of the whole; none is empty, as a domain must have a mean.
        const double lack = share[e] - sum / count;
        for (std::size_t place = 0; place < 6; ++place)
          sixths[e][place] = std::max(kLeastSixth * share[e], 6.0 * near[place] / count + lack);
      },
      64);
}

}  // namespace

SoftImageBody::Parts SoftImageBody::build(const OccupancyGrid& matter, const TriMesh& surface, double spacing,
                                          const Quat& rotation, const Vec3& position, ElasticOptions& options,
                                          const CellMaterial& material) {
  require_positive("image volume", "density", options.density);
  require_positive("image volume", "Young's modulus", options.young);
  if (!(options.poisson > -1.0 && options.poisson < 0.5))
    throw InputError(
        fmt::format("image volume: Poisson's ratio is {}; it must be between -1 and 0.5", options.poisson));
  Parts parts;
  parts.area = surface_area(surface);
  parts.box = matter.matter_box();
  std::vector<Vec3> x, of_matter;
  std::vector<double> young;  // [Pa] of the matter of each particle
  const double cell = matter.spacing * matter.spacing * matter.spacing;
  for (int k = 0; k < matter.cells.z(); ++k)
    for (int j = 0; j < matter.cells.y(); ++j)
      for (int i = 0; i < matter.cells.x(); ++i) {
        const int share = matter.share[matter.index(i, j, k)];
        if (share < kLeastMatter) continue;
        x.push_back(matter.center(i, j, k)), of_matter.push_back(middle_of_matter(matter, i, j, k));
        parts.carriage.volume.push_back(cell * share / 255.0);
        const std::size_t at = matter.index(i, j, k);
        parts.carriage.mass.push_back(material.density.empty() ? options.density * parts.carriage.volume.back()
                                                               : cell * static_cast<double>(material.density[at]));
        if (!material.young.empty()) young.push_back(static_cast<double>(material.young[at]) * 255.0 / share);
      }
  // Cells that are mostly full hold tetrahedra all over.
  std::vector<std::uint8_t> whole;
  for (const double v : parts.carriage.volume) whole.push_back(v > 0.5 * cell ? 1 : 0);
  HeldPoints held = lattice_around(x, spacing, matter.spacing, whole);
  parts.mesh = std::move(held.mesh);
  matter_shares(parts.mesh, matter, spacing, parts.stiffness, parts.edges);
  // What lies in no tetrahedron stiffens the one that carries it.
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto e = static_cast<std::size_t>(held.embedding.tet[i]);
    const double more = held.outside[i] * parts.carriage.volume[i] / volume_of(parts.mesh, e);
    parts.stiffness[e] += more;
    for_nearest_edges(held.embedding.weights[i],
                      [&](std::size_t place, double w) { parts.edges[e][place] += 6.0 * w * more; });
  }
  parts.filled = parts.stiffness;
  if (!young.empty()) {
    // The pair's stiffness in contact goes by what yields first where both are in it.
    options.young = softness_mean(young, parts.carriage.volume);
    const std::vector<double> mean = element_means(parts.mesh, held.embedding.tet, young, parts.carriage.volume);
    for (std::size_t e = 0; e < mean.size(); ++e) {
      parts.stiffness[e] *= mean[e] / options.young;
      for (double& sixth : parts.edges[e]) sixth *= mean[e] / options.young;
    }
  }
  const Embedding carried = embed(parts.mesh, of_matter);
  parts.carriage.weights = rows_of(parts.mesh, carried);
  parts.surface.triangles = surface.triangles;
  parts.surface.weights = rows_of(parts.mesh, embed(parts.mesh, surface.vertices));

  for (Vec3& p : parts.mesh.vertices) p = position + rotation * p;
  for (const std::int32_t e : carried.tet) {
    const Tetrahedron& t = parts.mesh.tets[static_cast<std::size_t>(e)];
    Mat3 sides;
    for (int k = 0; k < 3; ++k) sides.col(k) = parts.mesh.vertices[t[k + 1]] - parts.mesh.vertices[t[0]];
    const Mat3 g = sides.inverse().transpose();
    parts.carriage.gradient.push_back(-g.rowwise().sum());
    for (int k = 0; k < 3; ++k) parts.carriage.gradient.push_back(g.col(k));
  }
  return parts;
}

void SoftImageBody::show(std::span<const double> value, std::span<float> out) const {
  show_nodes(node_means(particle_count(), parts_.mesh.tets, tet_volumes(parts_.mesh), parts_.filled, value), out);
}

SoftImageBody::SoftImageBody(const OccupancyGrid& matter, const TriMesh& surface, double spacing, const Quat& rotation,
                             const Vec3& position, ElasticOptions options, const CellMaterial& material)
    : SoftImageBody(build(matter, surface, spacing, rotation, position, options, material), options) {}

SoftImageBody::SoftImageBody(Parts parts, const ElasticOptions& options)
    : CarriedBody(parts.mesh.vertices, parts.carriage, options.weights, parts.surface, options.young, options),
      parts_(std::move(parts)),
      elements_(parts_.mesh, options.neo_hookean ? ElasticLaw::StableNeoHookean : ElasticLaw::CorotationalLinear,
                Lame::from(options.young, options.poisson), options.averaging, parts_.stiffness, parts_.edges) {
  elements_.make_pattern(stiffness_);
  force_.assign(particle_count(), Vec3::Zero());
  areal_mass_ = CarriedBody::part(0).areal_mass;
  if (immobile() || !(parts_.area > 0.0)) return;
  const auto total = [](const std::vector<double>& x) { return std::accumulate(x.begin(), x.end(), 0.0); };
  areal_mass_ = std::max(areal_mass_, areal_mass(total(parts_.carriage.mass), total(parts_.carriage.volume),
                                                 parts_.area, parts_.box, CarriedBody::part(0).voxel_size));
}

}  // namespace brim
