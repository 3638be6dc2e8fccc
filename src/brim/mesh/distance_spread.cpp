#include "brim/mesh/distance_spread.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

// Measured worst excess of far distances on spheres, blobs, a torus and a gear: 14 % without passes, 6 % after 1, 2 %
// after 4.
constexpr int kPasses = 4;

// Strides of a grid, x fastest, and the neighbours of a node that exist.
struct Strides {
  int nx, ny, nz;
  explicit Strides(const Vec3i& n) : nx(n.x()), ny(n.y()), nz(n.z()) {}

  template <class F>
  void for_each_neighbour(std::size_t n, const F& f) const {
    const int i = static_cast<int>(n % nx), j = static_cast<int>(n / nx % ny), k = static_cast<int>(n / nx / ny);
    for (int c = std::max(0, k - 1); c <= std::min(nz - 1, k + 1); ++c)
      for (int b = std::max(0, j - 1); b <= std::min(ny - 1, j + 1); ++b)
        for (int a = std::max(0, i - 1); a <= std::min(nx - 1, i + 1); ++a) {
          const std::size_t m = a + static_cast<std::size_t>(nx) * (b + static_cast<std::size_t>(ny) * c);
          if (m != n) f(m);
        }
  }
};

// Widens the marked nodes by r nodes along one axis.
void dilate(std::vector<std::uint8_t>& mark, std::size_t stride, int length, int r) {
  const std::size_t lines = mark.size() / static_cast<std::size_t>(length);
  parallel_for(
      lines,
      [&](std::size_t line) {
        const std::size_t first = line / stride * stride * static_cast<std::size_t>(length) + line % stride;
        std::vector<std::uint8_t> wide(static_cast<std::size_t>(length), 0);
        int last_marked = -r - 1;
        for (int i = 0; i < length; ++i) {
          if (mark[first + stride * i]) last_marked = i;
          wide[i] = i - last_marked <= r;
        }
        last_marked = length + r;
        for (int i = length - 1; i >= 0; --i) {
          if (mark[first + stride * i]) last_marked = i;
          if (last_marked - i <= r) wide[i] = 1;
        }
        for (int i = 0; i < length; ++i) mark[first + stride * i] = wide[i];
      },
      16);
}

// Nodes that may lie within the band: the boxes of the triangles, widened.
std::vector<std::uint8_t> near_nodes(const GridLayout& l, const TriMesh& mesh, double band) {
  std::vector<std::uint8_t> mark(l.count(), 0);
  for (const Triangle& t : mesh.triangles) {
    Aabb box;
    for (const std::int32_t v : t) box.extend(mesh.vertices[v]);
    const auto to_node = [&](const Vec3& p, double shift) {
      const Vec3 x = ((p - l.origin) / l.spacing).array() + shift;
      return Vec3i(x.array().floor().cast<int>().max(0).min(l.nodes.array() - 1));
    };
    const Vec3i lo = to_node(box.lo, 0.0), hi = to_node(box.hi, 1.0);
    for (int k = lo.z(); k <= hi.z(); ++k)
      for (int j = lo.y(); j <= hi.y(); ++j) {
        const std::size_t row = static_cast<std::size_t>(l.nodes.x()) * (j + static_cast<std::size_t>(l.nodes.y()) * k);
        std::fill(mark.begin() + static_cast<std::ptrdiff_t>(row + lo.x()),
                  mark.begin() + static_cast<std::ptrdiff_t>(row + hi.x() + 1), std::uint8_t{1});
      }
  }
  const int r = static_cast<int>(std::ceil(band / l.spacing));
  const auto nx = static_cast<std::size_t>(l.nodes.x()), ny = static_cast<std::size_t>(l.nodes.y());
  dilate(mark, 1, l.nodes.x(), r);
  dilate(mark, nx, l.nodes.y(), r);
  dilate(mark, nx * ny, l.nodes.z(), r);
  return mark;
}

double squared_distance(const TriMesh& mesh, std::int32_t t, const Vec3& p) {
  const Triangle& c = mesh.triangles[t];
  return (closest_on_triangle(p, mesh.vertices[c[0]], mesh.vertices[c[1]], mesh.vertices[c[2]]).point - p)
      .squaredNorm();
}

// Values and nearest triangles of a grid as they spread. Used once.
class DistanceSpread {
 public:
  DistanceSpread(const GridLayout& layout, const SurfaceTree& tree, double band)
      : layout_(layout),
        tree_(tree),
        mesh_(tree.mesh()),
        band_(band),
        nx_(static_cast<std::size_t>(layout.nodes.x())),
        strides_(layout.nodes),
        values_(layout.count()),
        nearest_(layout.count(), -1),
        done_(near_nodes(layout, mesh_, band)) {}

  std::vector<float> values(const NodeValue& value) {
    fill_band(value);
    for (std::vector<std::size_t> layer = first_layer(); !layer.empty(); layer = next_layer(layer)) fill(layer);
    correct_far_nodes();
    return std::move(values_);
  }

 private:
  // The band, by exact search.
  void fill_band(const NodeValue& value) {
    parallel_for(layout_.row_count(), [&](std::size_t row) {
      std::int32_t near = 0;  // of the node before: most often not far
      for (std::size_t n = row * nx_; n < (row + 1) * nx_; ++n) {
        if (!done_[n]) continue;
        const Vec3 p = position(n);
        const ClosestPoint c = tree_.closest_from(p, near);
        near = c.triangle;
        values_[n] = value(p, c);
        nearest_[n] = c.triangle;
      }
    });
  }

  // The first layer: unfinished nodes beside finished ones. Rows are gathered in order.
  std::vector<std::size_t> first_layer() const {
    std::vector<std::vector<std::size_t>> found(layout_.row_count());
    parallel_for(layout_.row_count(), [&](std::size_t row) {
      for (std::size_t n = row * nx_; n < (row + 1) * nx_; ++n) {
        if (done_[n]) continue;
        bool beside = false;
        strides_.for_each_neighbour(n, [&](std::size_t m) { beside = beside || done_[m]; });
        if (beside) found[row].push_back(n);
      }
    });
    std::vector<std::size_t> layer;
    for (const auto& row : found) layer.insert(layer.end(), row.begin(), row.end());
    return layer;
  }

  // Gives a layer its values. Finished neighbours only are read, nodes of this layer only are written.
  void fill(const std::vector<std::size_t>& layer) {
    parallel_for(
        layer.size(),
        [&](std::size_t index) {
          const std::size_t n = layer[index];
          const Vec3 p = position(n);
          std::array<std::int32_t, 26> tried;
          int count = 0;
          double best2 = std::numeric_limits<double>::infinity();
          bool inside = false;
          strides_.for_each_neighbour(n, [&](std::size_t m) {
            if (!done_[m]) return;
            const std::int32_t t = nearest_[m];
            if (std::find(tried.begin(), tried.begin() + count, t) != tried.begin() + count) return;
            tried[count++] = t;
            const double d2 = squared_distance(mesh_, t, p);
            if (d2 >= best2) return;
            best2 = d2;
            nearest_[n] = t;
            inside = values_[m] < 0.0f;
          });
          values_[n] = static_cast<float>(inside ? -std::sqrt(best2) : std::sqrt(best2));
        },
        64);
  }

  // Finishes a layer. Returns the unfinished nodes beside it.
  std::vector<std::size_t> next_layer(const std::vector<std::size_t>& layer) {
    for (const std::size_t n : layer) done_[n] = 1;
    std::vector<std::size_t> next;
    for (const std::size_t n : layer)
      strides_.for_each_neighbour(n, [&](std::size_t m) {
        if (done_[m]) return;
        done_[m] = 2;  // already on the list
        next.push_back(m);
      });
    for (const std::size_t n : next) done_[n] = 0;
    return next;
  }

  // Fronts that met too early: far nodes try their neighbours' triangles again, from a copy; those that have changed
  // since they were tried last.
  void correct_far_nodes() {
    const std::vector<std::uint8_t> exact = near_nodes(layout_, mesh_, band_);
    std::vector<std::uint8_t> changed(layout_.count(), 1);
    for (int pass = 0; pass < kPasses; ++pass) {
      const std::vector<std::int32_t> before = nearest_;
      std::vector<std::uint8_t> changes(layout_.count(), 0);
      parallel_for(layout_.row_count(), [&](std::size_t row) {
        for (std::size_t n = row * nx_; n < (row + 1) * nx_; ++n)
          if (!exact[n]) changes[n] = correct(n, before, changed);
      });
      changed = std::move(changes);
    }
  }

  // Tries the triangles of the changed neighbours of a node. Returns 1 when one of them is nearer.
  std::uint8_t correct(std::size_t n, const std::vector<std::int32_t>& before,
                       const std::vector<std::uint8_t>& changed) {
    const Vec3 p = position(n);
    std::array<std::int32_t, 27> tried;
    int count = 0;
    tried[count++] = before[n];
    double best2 = -1.0;  // not known yet
    strides_.for_each_neighbour(n, [&](std::size_t m) {
      const std::int32_t t = before[m];
      if (!changed[m] || std::find(tried.begin(), tried.begin() + count, t) != tried.begin() + count) return;
      if (best2 < 0.0) best2 = squared_distance(mesh_, before[n], p);
      tried[count++] = t;
      const double d2 = squared_distance(mesh_, t, p);
      if (d2 >= best2) return;
      best2 = d2;
      nearest_[n] = t;
    });
    if (nearest_[n] == before[n]) return 0;
    values_[n] = static_cast<float>(std::copysign(std::sqrt(best2), static_cast<double>(values_[n])));
    return 1;
  }

  Vec3 position(std::size_t n) const { return layout_.position(n / nx_, static_cast<int>(n % nx_)); }

  const GridLayout& layout_;
  const SurfaceTree& tree_;
  const TriMesh& mesh_;
  double band_;
  std::size_t nx_;
  Strides strides_;
  std::vector<float> values_;
  std::vector<std::int32_t> nearest_;  // triangle of each node, -1: not known
  std::vector<std::uint8_t> done_;
};

}  // namespace

GridLayout grid_layout(const Aabb& box, double spacing, std::size_t max_nodes) {
  if (!(spacing > 0.0) || !std::isfinite(spacing))
    throw InputError(fmt::format("distance grid: spacing is {} m; it must be positive and finite", spacing));
  // Counted in floating point first: a tiny spacing must not overflow.
  const Vec3 cells = (box.extent() / spacing).array().ceil().max(1.0);
  const double count = (cells.array() + 1.0).prod();
  if (!(count <= static_cast<double>(max_nodes)))
    throw InputError(
        fmt::format("distance grid: spacing {} m on a solid of {:.4g} x {:.4g} x {:.4g} m asks for {:.3g} nodes, more "
                    "than the limit "
                    "of {}; use a spacing of about {:.3g} m",
                    spacing, box.extent().x(), box.extent().y(), box.extent().z(), count, max_nodes,
                    spacing * std::cbrt(count / static_cast<double>(max_nodes)) * 1.01));
  GridLayout l;
  l.spacing = spacing;
  l.nodes = (cells.cast<int>().matrix() + Vec3i::Ones());
  // The rounding is shared by both sides.
  l.origin = box.center() - 0.5 * spacing * cells.matrix();
  return l;
}

std::vector<float> spread_distance(const GridLayout& l, const SurfaceTree& tree, double band, const NodeValue& value) {
  BRIM_CHECK(band, >=, 3.0 * l.spacing);
  return DistanceSpread(l, tree, band).values(value);
}

}  // namespace brim
