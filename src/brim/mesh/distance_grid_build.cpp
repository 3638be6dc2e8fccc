#include <algorithm>
#include <cmath>
#include <utility>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/distance.h"
#include "brim/mesh/distance_grid.h"
#include "brim/mesh/distance_spread.h"
#include "brim/mesh/isosurface.h"
#include "brim/mesh/topology.h"

namespace brim {

namespace {

// Opening of the fast winding number: only its side of 1/2 counts here.
constexpr double kBeta = 2.0;

void require_closed(const TriMesh& mesh) {
  const MeshReport r = inspect(mesh);
  const char* advice =
      "choose the treatment winding_number (closes holes) or thickness (a sheet with a thickness) instead";
  if (r.boundary_edges == 0 && r.repeated_triangles > 0)
    throw InputError(fmt::format("the surface is there twice: {} triangles are repeated; leave them out, or {}",
                                 r.repeated_triangles, advice));
  if (!r.closed())
    throw InputError(fmt::format(
        "the surface is not closed: {} boundary edges{}; {}", r.boundary_edges,
        r.duplicate_vertices > 0 ? fmt::format(" (it has {} duplicate vertices: weld them first)", r.duplicate_vertices)
                                 : std::string(),
        advice));
  if (!r.oriented())
    throw InputError(fmt::format("the surface is closed, but {} edges lie between triangles of opposite sense; {}",
                                 r.misoriented_edges, advice));
  if (!(r.volume > 0.0))
    throw InputError(
        fmt::format("the surface encloses {} m³: its triangles face inwards or it is flat; turn them", r.volume));
}

// A true signed distance changes by at most the step between nodes. Where a sign change breaks that, the surface
// passes through itself and the pseudonormal of its nearest sheet says nothing about inside.
void require_consistent_signs(const GridLayout& l, const std::vector<float>& values) {
  const std::array<std::size_t, 3> stride = {
      1, static_cast<std::size_t>(l.nodes.x()),
      static_cast<std::size_t>(l.nodes.x()) * static_cast<std::size_t>(l.nodes.y())};
  std::size_t n = 0, broken = 0;
  for (int k = 0; k < l.nodes.z(); ++k)
    for (int j = 0; j < l.nodes.y(); ++j)
      for (int i = 0; i < l.nodes.x(); ++i, ++n) {
        const std::array<bool, 3> has_next = {i + 1 < l.nodes.x(), j + 1 < l.nodes.y(), k + 1 < l.nodes.z()};
        for (int a = 0; a < 3; ++a) {
          if (!has_next[a]) continue;
          const float u = values[n], v = values[n + stride[a]];
          broken += (u < 0.0f) != (v < 0.0f) && std::abs(u) + std::abs(v) > l.spacing * 1.001;
        }
      }
  if (broken > 0)
    throw InputError(
        fmt::format("the surface is closed but passes through itself (the signs of {} pairs of neighbouring "
                    "nodes contradict each other); choose the treatment winding_number",
                    broken));
}

std::vector<float> closed_values(const GridLayout& l, const SurfaceTree& tree, double band) {
  std::vector<float> values = spread_distance(l, tree, band, [&](const Vec3& p, const ClosestPoint& c) {
    return static_cast<float>(tree.inside(p, c) ? -c.distance : c.distance);
  });
  require_consistent_signs(l, values);
  return values;
}

std::vector<float> thickness_values(const GridLayout& l, const SurfaceTree& tree, double thickness, double band) {
  std::vector<float> values = spread_distance(l, tree, band + 0.5 * thickness, [](const Vec3&, const ClosestPoint& c) {
    return static_cast<float>(c.distance);
  });
  for (float& v : values) v -= static_cast<float>(0.5 * thickness);
  return values;
}

std::vector<float> winding_values(const GridLayout& l, const SurfaceTree& tree, double band) {
  std::vector<float> values(l.count());
  const auto nx = static_cast<std::size_t>(l.nodes.x());
  parallel_for(l.row_count(), [&](std::size_t row) {
    for (std::size_t i = 0; i < nx; ++i)
      values[row * nx + i] = static_cast<float>(0.5 - tree.winding_number(l.position(row, static_cast<int>(i)), kBeta));
  });
  // The winding number jumps at the triangles and is smooth across holes; halving finds either.
  const auto cut = [&](const Vec3& inside, const Vec3& outside, double, double) {
    double a = 0.0, b = 1.0;
    for (int k = 0; k < 8; ++k) {
      const double m = 0.5 * (a + b);
      (tree.winding_number(inside + m * (outside - inside), kBeta) > 0.5 ? a : b) = m;
    }
    return 0.5 * (a + b);
  };
  TriMesh surface = isosurface({l.origin, l.spacing, l.nodes, values}, cut);
  if (surface.triangles.empty()) return values;
  const SurfaceTree skin(std::move(surface));
  const std::vector<float> unsigned_values =
      spread_distance(l, skin, band, [](const Vec3&, const ClosestPoint& c) { return static_cast<float>(c.distance); });
  for (std::size_t n = 0; n < values.size(); ++n)
    values[n] = values[n] < 0.0f ? -unsigned_values[n] : unsigned_values[n];
  return values;
}

}  // namespace

DistanceGrid make_distance_grid(const TriMesh& mesh, const DistanceGridOptions& o) {
  if (!(o.margin >= 0.0) || !std::isfinite(o.margin))
    throw InputError(fmt::format("distance grid: margin is {} m; it must be 0 or more", o.margin));
  const bool sheet = o.treatment == SurfaceTreatment::Thickness;
  if (sheet && (!(o.thickness > 0.0) || !std::isfinite(o.thickness)))
    throw InputError(fmt::format("distance grid: thickness is {} m; a sheet needs a positive one", o.thickness));
  if (o.treatment == SurfaceTreatment::Closed) require_closed(mesh);
  const auto shared = std::make_shared<const SurfaceTree>(mesh);
  const SurfaceTree& tree = *shared;
  const double around = o.margin + 3.0 * o.spacing + (sheet ? 0.5 * o.thickness : 0.0);
  const GridLayout l = grid_layout(tree.box().inflated(around), o.spacing, o.max_nodes);

  const double band = std::max(o.exact_band, 4.0 * o.spacing);
  std::vector<float> values;
  switch (o.treatment) {
    case SurfaceTreatment::Closed:
      values = closed_values(l, tree, band);
      break;
    case SurfaceTreatment::WindingNumber:
      values = winding_values(l, tree, band);
      break;
    case SurfaceTreatment::Thickness:
      values = thickness_values(l, tree, o.thickness, band);
      break;
  }
  if (*std::min_element(values.begin(), values.end()) >= 0.0f)
    throw InputError(fmt::format(
        "distance grid: no node at spacing {} m lies inside the solid; take a spacing below the thinnest part{}",
        o.spacing,
        o.treatment == SurfaceTreatment::WindingNumber ? ", or turn the triangles if they face inwards" : ""));
  DistanceGrid grid(l.origin, l.spacing, l.nodes, std::move(values), o.interpolation);
  if (o.treatment == SurfaceTreatment::Closed && o.interpolation == Interpolation::Tricubic) {
    auto exact = std::make_shared<const ExactCells>(shared, grid);
    if (!exact->empty()) grid.set_exact_cells(std::move(exact));
  }
  return grid;
}

DistanceGrid sample_distance(const Aabb& box, double spacing, const std::function<double(const Vec3&)>& distance,
                             std::size_t max_nodes) {
  if (box.empty() || !box.lo.allFinite() || !box.hi.allFinite())
    throw InputError("distance grid: the box to sample is empty or not finite");
  const GridLayout l = grid_layout(box, spacing, max_nodes);
  std::vector<float> values(l.count());
  const auto nx = static_cast<std::size_t>(l.nodes.x());
  parallel_for(l.row_count(), [&](std::size_t row) {
    for (std::size_t i = 0; i < nx; ++i)
      values[row * nx + i] = static_cast<float>(distance(l.position(row, static_cast<int>(i))));
  });
  return {l.origin, l.spacing, l.nodes, std::move(values)};
}

}  // namespace brim
