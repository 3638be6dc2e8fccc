#include "brim/mesh/tet_lattice.h"

#include <algorithm>
#include <cmath>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/bcc_lattice.h"
#include "brim/mesh/distance.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/topology.h"

namespace brim {

namespace {

// A node moves onto the surface when an edge is cut nearer to it than this share of the edge (Labelle and Shewchuk,
// table 1): with these the worst dihedral angles are bounded.
constexpr double kSnapLong = 0.24999, kSnapShort = 0.41189;
/// Share of a closed surface's volume that a lattice may miss before one is tried whose cells end at the sides of the
/// surface's box; share of a cell that its cells may be larger for it, per cell of an axis.
constexpr double kFills = 0.01, kCoarser = 0.25;

using EdgeKey = std::uint64_t;
EdgeKey edge_key(std::int32_t a, std::int32_t b) {
  return static_cast<EdgeKey>(std::min(a, b)) << 32 | static_cast<EdgeKey>(std::max(a, b));
}

// An edge that the surface crosses.
struct CutEdge {
  std::int32_t a, b;  // inside end, outside end
  double t;           // where, from a to b
};

// Root of the distance on an edge by the Illinois rule.
double cut_parameter(const DistanceFunction& distance, const Vec3& a, const Vec3& b, double fa, double fb) {
  double lo = 0.0, hi = 1.0;
  const double enough = 1e-6 * (b - a).norm();
  double t = 0.5;
  int side = 0;
  for (int k = 0; k < 30; ++k) {
    t = std::clamp((lo * fb - hi * fa) / (fb - fa), lo, hi);
    const double f = distance(a + t * (b - a));
    if (std::abs(f) < enough) break;
    if (f < 0.0) {
      lo = t;
      fa = f;
      if (side == -1) fb *= 0.5;
      side = -1;
    } else {
      hi = t;
      fb = f;
      if (side == 1) fa *= 0.5;
      side = 1;
    }
  }
  return t;
}

class Stuffing {
 public:
  Stuffing(const BccLattice& lattice, const DistanceFunction& distance) : lattice_(lattice), distance_(distance) {
    const auto n = static_cast<std::size_t>(lattice.node_count());
    positions_.resize(n);
    values_.resize(n);
    parallel_for(
        n,
        [&](std::size_t i) {
          positions_[i] = lattice_.position(static_cast<std::int32_t>(i));
          values_[i] = distance_(positions_[i]);
        },
        64);
  }

  const std::vector<double>& values() const { return values_; }

  void find_cuts() {
    lattice_.for_each_edge([&](std::int32_t a, std::int32_t b) {
      if ((values_[a] < 0.0) != (values_[b] < 0.0) && values_[a] != 0.0 && values_[b] != 0.0)
        cuts_.push_back(values_[a] < 0.0 ? CutEdge{a, b, 0.0} : CutEdge{b, a, 0.0});
    });
    parallel_for(
        cuts_.size(),
        [&](std::size_t i) {
          CutEdge& c = cuts_[i];
          c.t = cut_parameter(distance_, positions_[c.a], positions_[c.b], values_[c.a], values_[c.b]);
        },
        64);
  }

  // Moves nodes that lie too near to a cut onto the nearest of their cuts, in the order of their index; the cuts at a
  // moved node disappear, because it is on the surface now.
  void snap() {
    std::vector<std::int32_t> first(values_.size() + 1, 0), at;
    for (const CutEdge& c : cuts_) ++first[c.a + 1], ++first[c.b + 1];
    for (std::size_t i = 0; i + 1 < first.size(); ++i) first[i + 1] += first[i];
    at.resize(2 * cuts_.size());
    std::vector<std::int32_t> next(first.begin(), first.end() - 1);
    for (std::size_t e = 0; e < cuts_.size(); ++e) {
      at[next[cuts_[e].a]++] = static_cast<std::int32_t>(e);
      at[next[cuts_[e].b]++] = static_cast<std::int32_t>(e);
    }
    for (std::size_t v = 0; v < values_.size(); ++v) {
      double best = std::numeric_limits<double>::infinity();
      Vec3 target = Vec3::Zero();
      for (std::int32_t k = first[v]; k < first[v + 1]; ++k) {
        const CutEdge& c = cuts_[at[k]];
        if (values_[c.a] == 0.0 || values_[c.b] == 0.0) continue;
        const bool is_long = lattice_.is_corner(c.a) == lattice_.is_corner(c.b);
        const double share = c.a == static_cast<std::int32_t>(v) ? c.t : 1.0 - c.t;
        const double length = share * (positions_[c.b] - positions_[c.a]).norm();
        if (share >= (is_long ? kSnapLong : kSnapShort) || length >= best) continue;
        best = length;
        target = positions_[c.a] + c.t * (positions_[c.b] - positions_[c.a]);
      }
      if (!std::isfinite(best)) continue;
      positions_[v] = target;
      values_[v] = 0.0;
    }
    std::erase_if(cuts_, [&](const CutEdge& c) { return values_[c.a] == 0.0 || values_[c.b] == 0.0; });
  }

  // Fills the part of each tetrahedron that is inside.
  TetMesh fill(std::size_t max_tets) {
    keys_.clear();
    for (const CutEdge& c : cuts_)
      keys_.push_back({edge_key(c.a, c.b), static_cast<std::int32_t>(positions_.size() + keys_.size())});
    for (const CutEdge& c : cuts_) positions_.push_back(positions_[c.a] + c.t * (positions_[c.b] - positions_[c.a]));
    std::sort(keys_.begin(), keys_.end());
    std::vector<Tetrahedron> tets;
    lattice_.for_each_tet([&](const Tetrahedron& t) {
      fill_one(t, tets);
      if (tets.size() > max_tets)
        throw InputError(fmt::format("tet lattice: spacing {} m gives more than {} tetrahedra; take a coarser one",
                                     lattice_.spacing(), max_tets));
    });
    return compact(tets);
  }

  TetMesh compact(std::vector<Tetrahedron>& tets) const {
    std::vector<std::int32_t> number(positions_.size(), -1);
    for (const Tetrahedron& t : tets)
      for (const std::int32_t v : t) number[v] = 0;
    TetMesh mesh;
    for (std::size_t v = 0; v < number.size(); ++v)
      if (number[v] == 0) {
        number[v] = static_cast<std::int32_t>(mesh.vertices.size());
        mesh.vertices.push_back(positions_[v]);
      }
    for (Tetrahedron& t : tets)
      for (std::int32_t& v : t) v = number[v];
    mesh.tets = std::move(tets);
    return mesh;
  }

 private:
  std::int32_t cut(std::int32_t a, std::int32_t b) const {
    const EdgeKey key = edge_key(a, b);
    const auto it = std::lower_bound(keys_.begin(), keys_.end(), std::pair{key, std::int32_t{-1}});
    BRIM_CHECK(it->first, ==, key);
    return it->second;
  }

  void add(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d, std::vector<Tetrahedron>& out) const {
    const double v = tet_volume(positions_[a], positions_[b], positions_[c], positions_[d]);
    // What is left of a tetrahedron with two nodes moved to the same place is nothing.
    if (v == 0.0) return;
    out.push_back(v > 0.0 ? Tetrahedron{a, b, c, d} : Tetrahedron{a, b, d, c});
  }

  // Whether the quad of face (a, b, outside node d) is split from a: else from b. Both neighbours of the face agree.
  // One long and one short edge cut: the diagonal ends at the long edge's cut. Two short ones: it starts at the node
  // with the even cell (parity rule), which alternates, so that no direction is preferred.
  bool from_first(std::int32_t a, std::int32_t b, std::int32_t d) const {
    const bool long_a = lattice_.is_corner(a) == lattice_.is_corner(d),
               long_b = lattice_.is_corner(b) == lattice_.is_corner(d);
    if (long_a != long_b) return long_b;
    const bool even_a = lattice_.is_even(a), even_b = lattice_.is_even(b);
    return even_a != even_b ? even_a : a < b;
  }

  // Prism with the triangles p and q (p[i] beside q[i]); split[i] tells whether the quad between i and (i + 1) % 3 is
  // cut from p[i] to q[i+1] (else from p[i+1] to q[i]). Three tetrahedra, unless the diagonals form a circle.
  bool add_prism(const std::array<std::int32_t, 3>& p, const std::array<std::int32_t, 3>& q,
                 const std::array<bool, 3>& split, std::vector<Tetrahedron>& out) const {
    static constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (const auto& o : kOrders) {
      std::array<int, 3> rank{};
      for (int k = 0; k < 3; ++k) rank[o[k]] = k;
      bool fits = true;
      for (int i = 0; i < 3; ++i) fits = fits && (rank[i] < rank[(i + 1) % 3]) == split[i];
      if (!fits) continue;
      add(p[o[0]], p[o[1]], p[o[2]], q[o[2]], out);
      add(p[o[0]], p[o[1]], q[o[1]], q[o[2]], out);
      add(p[o[0]], q[o[0]], q[o[1]], q[o[2]], out);
      return true;
    }
    return false;
  }

  void fill_one(const Tetrahedron& t, std::vector<Tetrahedron>& out) const {
    std::array<std::int32_t, 4> in{}, zero{}, outside{};
    int p = 0, z = 0, n = 0;
    for (const std::int32_t v : t) {
      if (values_[v] < 0.0)
        in[p++] = v;
      else if (values_[v] == 0.0)
        zero[z++] = v;
      else
        outside[n++] = v;
    }
    if (p == 0) return;
    if (n == 0) {
      add(t[0], t[1], t[2], t[3], out);
    } else if (p == 1) {
      std::array<std::int32_t, 3> base{};
      int k = 0;
      for (int i = 0; i < z; ++i) base[k++] = zero[i];
      for (int i = 0; i < n; ++i) base[k++] = cut(in[0], outside[i]);
      add(in[0], base[0], base[1], base[2], out);
    } else if (p == 2 && n == 1) {
      const std::int32_t a = in[0], b = in[1], c = zero[0], d = outside[0], ad = cut(a, d), bd = cut(b, d);
      if (from_first(a, b, d)) {
        add(a, b, bd, c, out);
        add(a, bd, ad, c, out);
      } else {
        add(a, b, ad, c, out);
        add(b, bd, ad, c, out);
      }
    } else if (p == 2) {
      const std::int32_t a = in[0], b = in[1], c = outside[0], d = outside[1];
      const std::array<std::int32_t, 3> pa = {a, cut(a, c), cut(a, d)}, pb = {b, cut(b, c), cut(b, d)};
      // Quads 0 (a, ac | b, bc) and 2 (ad, a | bd, b) lie on faces; quad 1 is on the surface and free: of the two
      // ways the one with the shorter diagonal, where it makes no circle.
      const bool face_c = from_first(a, b, c), face_d = !from_first(a, b, d);
      const bool shorter = (positions_[pa[1]] - positions_[pb[2]]).squaredNorm() <=
                           (positions_[pa[2]] - positions_[pb[1]]).squaredNorm();
      if (!add_prism(pa, pb, {face_c, shorter, face_d}, out)) add_prism(pa, pb, {face_c, !shorter, face_d}, out);
    } else {
      const std::int32_t d = outside[0];
      const std::array<std::int32_t, 3> low = {in[0], in[1], in[2]},
                                        high = {cut(in[0], d), cut(in[1], d), cut(in[2], d)};
      const bool done =
          add_prism(low, high,
                    {from_first(low[0], low[1], d), from_first(low[1], low[2], d), from_first(low[2], low[0], d)}, out);
      BRIM_CHECK(done, ==, true);
    }
  }

  const BccLattice& lattice_;
  const DistanceFunction& distance_;
  std::vector<Vec3> positions_;
  std::vector<double> values_;
  std::vector<CutEdge> cuts_;
  std::vector<std::pair<EdgeKey, std::int32_t>> keys_;
};

// Lattice tetrahedra with an inside corner, middle of an edge, or centre, and those that hold one of the points.
TetMesh cover(const BccLattice& lattice, const Stuffing& nodes, const DistanceFunction& distance,
              std::span<const Vec3> points, std::size_t max_tets) {
  std::vector<std::int64_t> wanted;
  for (const Vec3& p : points) wanted.push_back(lattice.tet_at(p));
  std::sort(wanted.begin(), wanted.end());
  std::vector<Tetrahedron> all, tets;
  std::vector<char> keep;
  std::int64_t number = 0;
  lattice.for_each_tet([&](const Tetrahedron& t) {
    double lowest = std::numeric_limits<double>::infinity();
    for (const std::int32_t v : t) lowest = std::min(lowest, nodes.values()[v]);
    const bool sure = lowest < 0.0 || std::binary_search(wanted.begin(), wanted.end(), number);
    ++number;
    // Farther than its longest edge from the solid: cannot meet it.
    if (!sure && lowest > lattice.spacing()) return;
    all.push_back(t);
    keep.push_back(sure);
  });
  parallel_for(
      all.size(),
      [&](std::size_t e) {
        if (keep[e]) return;
        Vec3 center = Vec3::Zero();
        for (int i = 0; i < 4; ++i) {
          const Vec3 x = lattice.position(all[e][i]);
          center += 0.25 * x;
          for (int j = i + 1; j < 4; ++j)
            if (distance(0.5 * (x + lattice.position(all[e][j]))) < 0.0) keep[e] = 1;
        }
        if (distance(center) < 0.0) keep[e] = 1;
      },
      64);
  for (std::size_t e = 0; e < all.size(); ++e)
    if (keep[e]) tets.push_back(all[e]);
  if (tets.size() > max_tets)
    throw InputError(fmt::format("tet lattice: spacing {} m gives more than {} tetrahedra; take a coarser one",
                                 lattice.spacing(), max_tets));
  return nodes.compact(tets);
}

/// @param spacing_of_axes  [m] of the lattice, about `spacing`
TetMesh build(const DistanceFunction& distance, const Aabb& box, double spacing, const Vec3& spacing_of_axes,
              LatticeStyle style, std::size_t max_tets, std::span<const Vec3> points) {
  if (!(spacing > 0.0) || !std::isfinite(spacing))
    throw InputError(fmt::format("tet lattice: spacing is {} m; it must be positive and finite", spacing));
  if (box.empty() || !box.lo.allFinite() || !box.hi.allFinite())
    throw InputError("tet lattice: the box is empty or not finite");
  const double cells = ((box.extent() / spacing).array() + 4.0).prod();
  if (!(cells < static_cast<double>(max_tets)))
    throw InputError(fmt::format("tet lattice: spacing {} m asks for {:.3g} cells, more than {}; take a coarser one",
                                 spacing, cells, max_tets));
  const BccLattice lattice(box, spacing_of_axes);
  Stuffing stuffing(lattice, distance);
  TetMesh mesh;
  if (style == LatticeStyle::Covering) {
    mesh = cover(lattice, stuffing, distance, points, max_tets);
  } else {
    stuffing.find_cuts();
    stuffing.snap();
    mesh = stuffing.fill(max_tets);
  }
  if (mesh.tets.empty())
    throw InputError(fmt::format(
        "tet lattice: nothing of the solid is left at spacing {} m; take one below its thinnest part", spacing));
  return mesh;
}

}  // namespace

TetMesh tet_lattice(const DistanceFunction& distance, const Aabb& box, double spacing, LatticeStyle style,
                    std::size_t max_tets) {
  return build(distance, box, spacing, Vec3::Constant(spacing), style, max_tets, {});
}

TetMesh tet_lattice(const TriMesh& closed_surface, double spacing, LatticeStyle style, std::size_t max_tets) {
  const MeshReport r = inspect(closed_surface);
  if (!r.closed() || !r.oriented() || !(r.volume > 0.0))
    throw InputError("tet lattice: the surface must be closed, oriented and face outwards, but it is: " + r.summary() +
                     "; for others sample a distance grid with a fitting treatment and fill that");
  const SurfaceTree tree(closed_surface);
  const auto filled = [&](const Vec3& of_axes) {
    return build([&](const Vec3& p) { return tree.signed_distance(p); }, tree.box(), spacing, of_axes, style, max_tets,
                 closed_surface.vertices);
  };
  TetMesh mesh = filled(Vec3::Constant(spacing));
  const auto miss = [&](const TetMesh& m) { return std::abs(tet_quality(m).total_volume - r.volume); };
  if (style == LatticeStyle::Covering || miss(mesh) <= kFills * r.volume) return mesh;
  // Sharp edges between nodes are cut off; cells that end at the sides of the box leave those of blocks whole.
  const Vec3 extent = tree.box().extent(), cells = (extent.array() / spacing - kCoarser).ceil().max(1.0);
  TetMesh fitted = filled(extent.cwiseQuotient(cells));
  return miss(fitted) < miss(mesh) ? fitted : mesh;
}

}  // namespace brim
