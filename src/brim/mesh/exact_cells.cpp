#include "brim/mesh/exact_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "brim/core/parallel.h"
#include "brim/mesh/distance_grid.h"

namespace brim {

namespace {

/// Triangles that a cell may look at, and those about it among which they are sought; cells with kinks up to which
/// exact ones are sought: beyond, surfaces are rough all over, and this would take long.
constexpr std::size_t kMostTriangles = 24, kMostInBox = 2000, kMostKinked = 1'000'000;
/// Places a side of a cell at which the nearest triangles are found.
constexpr int kPlaces = 4;
/// Lengths of half the sum of two unit normals that turn by 30 and by 2 degrees: an edge that turns by more than the
/// first is sharp; one between the two may be that of a facet of a round surface, which interpolation describes better.
constexpr double kSharp = 0.9659, kFlat = 0.99985;

/// The exact cells of a layer, in order.
struct Layer {
  std::vector<std::size_t> nodes;
  std::vector<std::uint32_t> counts;
  std::vector<std::int32_t> triangles;
};

TrianglePoint closest_on(const TriMesh& mesh, std::int32_t triangle, const Vec3& p) {
  const Triangle& c = mesh.triangles[static_cast<std::size_t>(triangle)];
  const auto corner = [&](std::size_t k) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(c[k])]; };
  return closest_on_triangle(p, corner(0), corner(1), corner(2));
}

/// Whether sides of the triangles at most so far from x are sharp, and no other but those within flat faces is there.
bool only_sharp_edges(const SurfaceTree& tree, const std::vector<std::int32_t>& triangles, const Vec3& x, double far) {
  const TriMesh& mesh = tree.mesh();
  bool sharp = false;
  for (const std::int32_t t : triangles) {
    const Triangle& c = mesh.triangles[static_cast<std::size_t>(t)];
    for (int k = 0; k < 3; ++k) {
      const double turn = 0.5 * tree.edge_normal(t, k).norm();
      if (turn > kFlat) continue;
      const Vec3 &a = mesh.vertices[static_cast<std::size_t>(c[static_cast<std::size_t>(k)])],
                 &b = mesh.vertices[static_cast<std::size_t>(c[static_cast<std::size_t>((k + 1) % 3)])];
      const Vec3 d = b - a;
      const double s = std::clamp((x - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
      if ((x - a - s * d).squaredNorm() > far * far) continue;
      if (turn > kSharp) return false;
      sharp = true;
    }
  }
  return sharp;
}

}  // namespace

ClosestPoint ExactCells::closest(const std::int32_t* triangles, std::size_t count, const Vec3& p) const {
  const TriMesh& mesh = tree_->mesh();
  ClosestPoint best;
  double best2 = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    const TrianglePoint q = closest_on(mesh, triangles[i], p);
    const double d2 = (p - q.point).squaredNorm();
    if (d2 >= best2) continue;
    best2 = d2;
    best = {0.0, q.point, q.barycentric, triangles[i], q.feature};
  }
  best.distance = std::sqrt(best2);
  return best;
}

double ExactCells::distance(const std::int32_t* triangles, std::size_t count, const Vec3& p) const {
  const ClosestPoint best = closest(triangles, count, p);
  return tree_->inside(p, best) ? -best.distance : best.distance;
}

void ExactCells::keep_nearest(const Vec3& lo, double spacing, std::vector<std::int32_t>& triangles) const {
  std::vector<std::int32_t> nearest;
  for (int i = 0; i < kPlaces * kPlaces * kPlaces; ++i) {
    const int j = i / kPlaces, k = j / kPlaces;
    const Vec3 at(i % kPlaces, j % kPlaces, k);
    nearest.push_back(closest(triangles.data(), triangles.size(), lo + spacing / (kPlaces - 1) * at).triangle);
  }
  std::sort(nearest.begin(), nearest.end());
  nearest.erase(std::unique(nearest.begin(), nearest.end()), nearest.end());
  triangles = std::move(nearest);
}

double ExactCells::value(std::size_t node, const Vec3& p) const {
  const std::uint32_t below = bits_[node >> 5] & ((1u << (node & 31)) - 1u);
  const std::size_t cell = before_[node >> 5] + static_cast<std::size_t>(std::popcount(below));
  return distance(triangles_.data() + first_[cell], first_[cell + 1] - first_[cell], p);
}

ExactCells::ExactCells(std::shared_ptr<const SurfaceTree> tree, const DistanceGrid& grid) : tree_(std::move(tree)) {
  const Vec3i nodes = grid.nodes();
  const auto nx = static_cast<std::size_t>(nodes.x()), nxy = nx * static_cast<std::size_t>(nodes.y());
  const double spacing = grid.spacing(), radius = 0.5 * std::sqrt(3.0) * spacing;
  const std::vector<float>& values = grid.values();
  bits_.assign(values.size() / 32 + 1, 0);
  before_.assign(bits_.size() + 1, 0), first_.assign(1, 0);
  const auto considered = [&](std::size_t node) {
    return KinkedCells::holds(grid.kinks().bits(), node) && std::abs(values[node]) < kFar * spacing;
  };
  std::size_t kinked = 0;
  for (std::size_t n = 0; n < values.size(); ++n) kinked += considered(n);
  if (kinked > kMostKinked) return;

  const TriMesh& mesh = tree_->mesh();
  std::vector<Layer> layers(static_cast<std::size_t>(nodes.z() - 1));
  parallel_for(layers.size(), [&](std::size_t k) {
    Layer& layer = layers[k];
    std::vector<std::int32_t> near;
    std::vector<double> at;
    for (std::size_t j = 0; j + 1 < static_cast<std::size_t>(nodes.y()); ++j)
      for (std::size_t i = 0; i + 1 < nx; ++i) {
        const std::size_t node = i + nx * j + nxy * k;
        if (!considered(node)) continue;
        const Vec3 lo = grid.origin() +
                        spacing * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)),
                   center = lo + Vec3::Constant(0.5 * spacing);
        // What is nearest to some point of the cell is at most `far` from its centre.
        near.clear(), at.clear();
        const double around = std::abs(values[node]) + 3.0 * radius;
        double far = around;
        tree_->overlapping({center - Vec3::Constant(around), center + Vec3::Constant(around)}, [&](std::int32_t t) {
          if (near.size() > kMostInBox) return;
          const TrianglePoint q = closest_on(mesh, t, center);
          near.push_back(t), at.push_back((q.point - center).norm());
          far = std::min(far, at.back() + 2.0 * radius);
        });
        if (near.size() > kMostInBox) continue;
        std::size_t kept = 0;
        for (std::size_t n = 0; n < near.size(); ++n)
          if (at[n] <= far) near[kept++] = near[n];
        near.resize(kept);
        if (near.size() > kMostTriangles || !only_sharp_edges(*tree_, near, center, far)) continue;
        std::sort(near.begin(), near.end());
        double worst = 0.0;
        for (int c = 0; c < 9; ++c) {  // the middle and beside each corner
          const Vec3 side(c & 1 ? 0.88 : 0.12, c & 2 ? 0.88 : 0.12, c & 4 ? 0.88 : 0.12),
              p = lo + spacing * (c < 8 ? side : Vec3::Constant(0.5));
          worst = std::max(worst, std::abs(grid.value(p) - distance(near.data(), near.size(), p)));
        }
        if (!(worst > kError * spacing)) continue;
        keep_nearest(lo, spacing, near);
        layer.nodes.push_back(node);
        layer.counts.push_back(static_cast<std::uint32_t>(near.size()));
        layer.triangles.insert(layer.triangles.end(), near.begin(), near.end());
      }
  });
  for (const Layer& layer : layers) {
    for (std::size_t c = 0; c < layer.nodes.size(); ++c) {
      bits_[layer.nodes[c] >> 5] |= 1u << (layer.nodes[c] & 31);
      first_.push_back(first_.back() + layer.counts[c]);
    }
    triangles_.insert(triangles_.end(), layer.triangles.begin(), layer.triangles.end());
  }
  for (std::size_t w = 0; w < bits_.size(); ++w)
    before_[w + 1] = before_[w] + static_cast<std::uint32_t>(std::popcount(bits_[w]));
}

}  // namespace brim
