#include "brim/contact/cube_contacts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "brim/contact/row_ramp.h"
#include "brim/contact/side_row.h"
#include "brim/core/parallel.h"
#include "brim/core/simd.h"
#include "brim/math/ramp.h"
#include "brim/raster/cube_distances.h"

namespace brim {

namespace {

/// One part's samples on a cube: the sampled nodes, their densities, and for solids their distances.
class Samples {
 public:
  Samples(const CubeSide& side, const NodeCube& cube, double w) : side_(side), cube_(cube), w_(w) {
    if (side.solid != nullptr) return;
    const Vec3i at = cube.first - kTileSize * Vec3i(side.tile.x, side.tile.y, side.tile.z) + Vec3i::Constant(kHalo);
    offset_ = block_index(at.x(), at.y(), at.z());
    shift_ = at;
  }

  /// Samples the wanted nodes that are missing. @return number of nodes sampled of a solid
  std::int64_t need(const NodeMask& wanted) {
    NodeMask missing = wanted.without(have_);
    if (!missing.any()) return 0;
    if (side_.solid == nullptr) {
      copy_rows(missing);
      return 0;
    }
    if (side_.solid->by_rows()) missing = missing.whole_rows();
    side_.solid->cube_distances(side_.pose, cube_, missing, 0.5 * w_ + (side_.by_distances ? cube_.h : 0.0), d_);
    cube_ramp(d_, w_, missing, rho_);
    have_ |= missing;
    return missing.count();
  }

  const float* rho() const { return rho_; }
  /// Distances of a solid that define its gradient direction, or null.
  const float* told_distances() const { return side_.by_distances ? d_ : nullptr; }
  /// Distances to the surface at the nodes of a row, within its ramp, [m].
  void distances(int j, int k, float* out) const {
    const int row = cube_index(0, j, k);
    if (side_.solid == nullptr) return row_ramp_inverse(rho_ + row, static_cast<float>(w_), out);
    const auto half = static_cast<float>(0.5 * w_);
    for (int i = 0; i < kCubeSize; ++i) out[i] = std::clamp(d_[row + i], -half, half);
  }
  std::int32_t source(int i, int j, int k) const {
    return side_.solid != nullptr ? 0 : side_.block->source[offset_ + block_index(i, j, k)];
  }

 private:
  void copy_rows(const NodeMask& missing) {
    // Rows at the end of a block are shorter than a cube's.
    const int n = std::min(kCubeSize, kBlockSize - shift_.x());
    missing.whole_rows().for_rows([&](int j, int k, std::uint8_t) {
      if (j + shift_.y() >= kBlockSize || k + shift_.z() >= kBlockSize) return;
      const double* from = side_.block->rho + offset_ + block_index(0, j, k);
      float* to = rho_ + cube_index(0, j, k);
      for (int i = 0; i < n; ++i) to[i] = static_cast<float>(from[i]);
    });
    have_ |= missing.whole_rows();
  }

  const CubeSide& side_;
  const NodeCube& cube_;
  double w_;
  int offset_ = 0;  ///< of the cube's first node in the block
  Vec3i shift_ = Vec3i::Zero();
  NodeMask have_;
  alignas(32) float rho_[kCubeNodes];
  alignas(32) float d_[kCubeNodes];
};

BRIM_INLINE CubeRow load_eight(const float* x) {
  CubeRow r;
  std::memcpy(&r, x, sizeof r);
  return r;
}

/// Finds the nodes with any density, and those that are full.
BRIM_WIDE void classify(const float* rho, const NodeMask& nodes, NodeMask& some, NodeMask& full) {
  for (int k = 0; k < kCubeSize; ++k) {
    some.plane[k] = full.plane[k] = 0;
    for (int j = 0; j < kCubeSize; ++j) {
      const std::uint8_t row = nodes.row(j, k);
      if (row == 0) continue;
      const CubeRow r = load_eight(rho + cube_index(0, j, k));
      some.set_row(j, k, bits_of(r > 0.0f) & row);
      full.set_row(j, k, bits_of(r >= 1.0f) & row);
    }
  }
}

/// Finds the nodes where the parts overlap, or nearly overlap with both on their ramps.
BRIM_WIDE void overlapping(const float* a, const float* b, float margin, const NodeMask& nodes, NodeMask& out) {
  for (int k = 0; k < kCubeSize; ++k) {
    out.plane[k] = 0;
    for (int j = 0; j < kCubeSize; ++j) {
      const std::uint8_t row = nodes.row(j, k);
      if (row == 0) continue;
      const CubeRow ra = load_eight(a + cube_index(0, j, k)), rb = load_eight(b + cube_index(0, j, k)), sum = ra + rb;
      const CubeRowFlags slopes = (ra > 0.0f) & (ra < 1.0f) & (rb > 0.0f) & (rb < 1.0f);
      out.set_row(j, k, bits_of((sum > 1.0f) | ((sum > 1.0f - margin) & slopes)) & row);
    }
  }
}

/// Nodes of a set whose six neighbours are in it too.
NodeMask inner(const NodeMask& m) {
  NodeMask in;
  for (int k = 1; k + 1 < kCubeSize; ++k) {
    const std::uint64_t p = m.plane[k];
    in.plane[k] = p & p << 1 & p >> 1 & p << 8 & p >> 8 & m.plane[k - 1] & m.plane[k + 1];
  }
  return in;
}

/// Gradient and bend of a side for the contacts of a row.
void find_side(const Samples& side, int j, int k, float inverse_h, SideRow& out) {
  RowDerivatives rho, told;
  const float* d = side.told_distances();
  row_derivatives(side.rho(), j, k, d == nullptr, rho);
  if (d != nullptr) row_derivatives(d, j, k, true, told);
  side_row(rho, d != nullptr ? &told : nullptr, inverse_h, out);
}

/// Appends the contacts at the nodes.
void append(const Samples& a, const Samples& b, const ContactPair& pair, const NodeCube& cube, const NodeMask& nodes,
            std::vector<Contact>& out) {
  const float inverse_h = static_cast<float>(1.0 / pair.h);
  nodes.for_rows([&](int j, int k, std::uint8_t row) {
    SideRow sa, sb;
    find_side(a, j, k, inverse_h, sa), find_side(b, j, k, inverse_h, sb);
    alignas(32) float distance_a[kCubeSize], distance_b[kCubeSize];
    a.distances(j, k, distance_a), b.distances(j, k, distance_b);
    for (int left = row; left != 0; left &= left - 1) {
      const int i = std::countr_zero(static_cast<unsigned>(left)), node = cube_index(i, j, k);
      const auto at = [i](const float(&x)[3][kCubeSize]) { return std::array<float, 3>{x[0][i], x[1][i], x[2][i]}; };
      Contact& c = out.emplace_back();
      c.node = cube.first + Vec3i(i, j, k);
      c.gradient_a = Vec3f(at(sa.gradient).data()), c.gradient_b = Vec3f(at(sb.gradient).data());
      c.bend_a = at(sa.bend), c.bend_b = at(sb.bend);
      const Vec3 g = (c.gradient_a - c.gradient_b).cast<double>();
      const double length = g.norm();
      // The distances to both surfaces are known along the common normal: the point lies half-way between them.
      const double to_a = distance_a[i], to_b = distance_b[i], shift = 0.5 * (to_a - to_b);
      c.point = pair.h * c.node.cast<double>();
      if (length > 0.0) c.point += (shift / length) * g;
      c.overlap = a.rho()[node] + b.rho()[node] - 1.0f;
      c.depth = static_cast<float>(-(to_a + to_b));
      c.source_a = a.source(i, j, k), c.source_b = b.source(i, j, k);
    }
  });
}

/// Sampling cost: the cheaper side is sampled first.
int cost(const CubeSide& s) { return s.solid == nullptr ? 0 : s.solid->by_rows() ? 1 : 2; }

/// False when the distances at the centre of a box exclude contact in it.
bool has_room(const CubeSide& a, const CubeSide& b, const ContactPair& pair, const NodeBox& box) {
  const Vec3 center = 0.5 * pair.h * (box.lo + box.hi).cast<double>();
  const double radius = 0.5 * pair.h * (box.hi - box.lo).cast<double>().norm() + 1e-6 * pair.h;
  const double gap = widest_gap(pair.margin) * pair.w;
  const double to_a = a.solid->least_distance(a.pose.to_local(center));
  if (to_a > 0.5 * pair.w + radius) return false;
  const double to_b = b.solid->least_distance(b.pose.to_local(center));
  return to_b <= 0.5 * pair.w + radius && to_a + to_b <= gap + 2.0 * radius;
}

/// Removes cells of 2x2x2 nodes in which the distances at their centres exclude contact (as has_room), eight at a time.
void cull_cells(const CubeSide& a, const CubeSide& b, const ContactPair& pair, const NodeCube& cube, NodeMask& own) {
  const double radius = (std::sqrt(0.75) + 1e-6) * pair.h;
  const auto most = static_cast<float>(0.5 * pair.w + radius),
             most_sum = static_cast<float>(widest_gap(pair.margin) * pair.w + 2.0 * radius);
  const CubeFrame frame_a(a.pose, cube), frame_b(b.pose, cube);
  float at[3][kCubeSize], to_a[kCubeSize], to_b[kCubeSize];
  Vec3i first[kCubeSize];
  int n = 0;
  const auto cull = [&] {
    for (int l = n; l < kCubeSize; ++l)
      for (auto& x : at) x[l] = x[0];
    a.solid->least_distances(frame_a, at[0], at[1], at[2], to_a);
    b.solid->least_distances(frame_b, at[0], at[1], at[2], to_b);
    for (int l = 0; l < n; ++l)
      if (to_a[l] > most || to_b[l] > most || to_a[l] + to_b[l] > most_sum)
        own = own.without(NodeMask::box(first[l], first[l] + Vec3i::Ones()));
    n = 0;
  };
  for (int k = 1; k < kCubeOwn; k += 2)
    for (int j = 1; j < kCubeOwn; j += 2)
      for (int i = 1; i < kCubeOwn; i += 2) {
        const std::uint64_t cell = NodeMask::box({i, j, k}, {i + 1, j + 1, k}).plane[k];
        if (((own.plane[k] | own.plane[k + 1]) & cell) == 0) continue;
        first[n] = {i, j, k};
        for (int x = 0; x < 3; ++x) at[x][n] = static_cast<float>(first[n][x]) + 0.5f;
        if (++n == kCubeSize) cull();
      }
  if (n > 0) cull();
}

}  // namespace

double widest_gap(double margin) {
  // Upper bound of the largest t with 3 t² − 2 t³ <= margin: t² = margin/(3 − 2 t), and t <= 1/2 for margin <= 1/2.
  // The cubic is odd about t = 1/2.
  if (margin <= 0.5) return std::sqrt(0.5 * std::max(0.0, margin));
  return 0.5 + std::sin(std::asin(std::min(1.0, 2.0 * margin - 1.0)) / 3.0);
}

void find_in_cube(const CubeSide& side_a, const CubeSide& side_b, const ContactPair& pair, const NodeBox& box,
                  CubeFinds& finds) {
  const NodeCube cube{box.lo - Vec3i::Ones(), pair.h};
  NodeMask room = NodeMask::box(Vec3i::Ones(), box.hi - cube.first);
  if (cost(side_a) == 2 && cost(side_b) == 2) cull_cells(side_a, side_b, pair, cube, room);
  Samples a(side_a, cube, pair.w), b(side_b, cube, pair.w);
  const bool swap = cost(side_b) < cost(side_a);
  Samples &first = swap ? b : a, &second = swap ? a : b;
  NodeMask some, full_a, full_b, touching;
  finds.nodes += first.need(room);
  classify(first.rho(), room, some, full_a);
  if (!some.any()) return;
  finds.nodes += second.need(some);
  finds.boxes.push_back(box);
  overlapping(a.rho(), b.rho(), static_cast<float>(pair.margin), some, touching);
  if (!touching.any()) return;
  const NodeMask around = touching.grown();
  finds.nodes += a.need(around) + b.need(around);
  classify(a.rho(), around, some, full_a);
  classify(b.rho(), around, some, full_b);
  // A part has no slope at nodes that are full and whose neighbours are full.
  NodeMask engulfed = inner(full_a);
  engulfed &= inner(full_b);
  engulfed &= touching;
  finds.engulfed += engulfed.count();
  append(a, b, pair, cube, touching.without(engulfed), finds.contacts);
}

void find_in_tile(const CubeSide& a, const CubeSide& b, const ContactPair& pair, const TileKey& tile, Octants octants,
                  CubeFinds& finds) {
  constexpr int kOctant = kTileSize / 2;
  for (int o = 0; o < 8; ++o) {
    if (!(octants >> o & 1)) continue;
    const Vec3i first = kTileSize * Vec3i(tile.x, tile.y, tile.z) + kOctant * Vec3i(o & 1, o >> 1 & 1, o >> 2);
    find_in_cube(a, b, pair, {first, first + Vec3i::Constant(kOctant - 1)}, finds);
  }
}

void find_between_solids(const CubeSide& a, const CubeSide& b, const ContactPair& pair, const NodeBox& box,
                         CubeFinds& finds) {
  if (!has_room(a, b, pair, box)) return;
  const Vec3i n = box.hi - box.lo + Vec3i::Ones();
  int axis = 0;
  if (n.maxCoeff(&axis) <= kCubeOwn) return find_in_cube(a, b, pair, box, finds);
  // Whole cubes on the lower side.
  NodeBox lower = box, upper = box;
  upper.lo[axis] = box.lo[axis] + kCubeOwn * std::max(1, n[axis] / (2 * kCubeOwn));
  lower.hi[axis] = upper.lo[axis] - 1;
  find_between_solids(a, b, pair, lower, finds);
  find_between_solids(a, b, pair, upper, finds);
}

void gather(std::span<const PairFinds> pieces, ContactSet& set) {
  std::vector<std::size_t> first(pieces.size() + 1, 0);
  set.engulfed = 0;
  for (ContactPair& p : set.pairs) p.begin = p.end = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const CubeFinds& f = *pieces[i].finds;
    first[i + 1] = first[i] + f.contacts.size();
    set.engulfed += f.engulfed;
    ContactPair& p = set.pairs[pieces[i].pair];
    if (p.end == 0) p.begin = first[i];
    p.end = first[i + 1];
  }
  set.resize(first.back());
  parallel_for(
      pieces.size(),
      [&](std::size_t i) {
        std::size_t c = first[i];
        for (const Contact& contact : pieces[i].finds->contacts) set.set(c++, contact);
      },
      16);
}

}  // namespace brim
