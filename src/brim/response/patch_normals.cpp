#include "brim/response/patch_normals.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "brim/contact/tangent_frame.h"
#include "brim/core/widest.h"
#include "brim/math/wide_vectors.h"

namespace brim {

namespace {

constexpr double kLeastWeight = 1e-9;

/// The first n of eight consecutive triples; zeros for the rest.
BRIM_INLINE WideVectors load_threes(const float* from, int n) {
  WideVectors v{};
  for (int l = 0; l < n; ++l) v.x[l] = from[3 * l], v.y[l] = from[3 * l + 1], v.z[l] = from[3 * l + 2];
  return v;
}

/// Unpacks tensors tangential to g from the three components stored by contacts to xx, yy, zz, xy, xz, yz.
BRIM_INLINE void unpack(const WideVectors& g, const WideVectors& packed, WideFloats* m) {
  const WideFloats size = length(g), none{};
  const WideIds known = size > 0.0f;
  const TangentFrame<WideFloats> t(g.x / size, g.y / size, g.z / size);
  WideFloats u[3], v[3];
  for (int i = 0; i < 3; ++i) {
    u[i] = packed.x * t.u[i] + packed.y * t.v[i];
    v[i] = packed.y * t.u[i] + packed.z * t.v[i];
  }
  const auto entry = [&](int i, int j) BRIM_LAMBDA_INLINE { return known ? u[i] * t.u[j] + v[i] * t.v[j] : none; };
  m[0] = entry(0, 0), m[1] = entry(1, 1), m[2] = entry(2, 2);
  m[3] = entry(0, 1), m[4] = entry(0, 2), m[5] = entry(1, 2);
}

/// Frobenius norm of the tensors M projected across n: of T M T with T = 1 − n nᵀ.
BRIM_INLINE WideFloats curvature(const WideFloats* m, const WideVectors& n) {
  const WideVectors diagonal{m[0], m[1], m[2]}, off{m[3], m[4], m[5]};
  const WideVectors Mn{m[0] * n.x + m[3] * n.y + m[4] * n.z, m[3] * n.x + m[1] * n.y + m[5] * n.z,
                       m[4] * n.x + m[5] * n.y + m[2] * n.z};
  const WideFloats nMn = dot(n, Mn), all = dot(diagonal, diagonal) + 2.0f * dot(off, off);
  const WideFloats square = all - 2.0f * dot(Mn, Mn) + nMn * nMn;
  return wide_root(square > 0.0f ? square : WideFloats{});
}

/// Spreads the data of `count` contacts from c on: ∇ρ_a − ∇ρ_b and the two tensors, by their weights.
BRIM_WIDE void spread(const ContactSet& contacts, std::size_t c, std::size_t count, const float* weight,
                      const PatchLattice& lattice, PatchField<InTwo::Floats>& field) {
  const float *ga = contacts.gradient_a.data()->data(), *gb = contacts.gradient_b.data()->data();
  const float *bend_a = contacts.bend_a.data()->data(), *bend_b = contacts.bend_b.data()->data();
  for (std::size_t first = 0; first < count; first += kWideLanes) {
    const int n = static_cast<int>(std::min<std::size_t>(kWideLanes, count - first));
    const std::size_t at = 3 * (c + first);
    const WideVectors a = load_threes(ga + at, n), b = load_threes(gb + at, n);
    WideFloats row[kWidestLanes] = {a.x - b.x, a.y - b.y, a.z - b.z};
    unpack(a, load_threes(bend_a + at, n), row + 3);
    unpack(b, load_threes(bend_b + at, n), row + 9);
    for (int l = 0; l < n; ++l) {
      float sample[kWidestLanes];
      for (int i = 0; i < kWidestLanes; ++i) sample[i] = row[i][l];
      field.add(lattice[first + l], weight[first + l] * load_widest<InTwo>(sample));
    }
  }
}

/// Curvatures of both parts about each contact, perpendicular to the direction of the force there.
BRIM_WIDE void read_curvatures(const PatchField<InTwo::Floats>& field, const PatchLattice& lattice, std::size_t count,
                               float* of_a, float* of_b) {
  for (std::size_t first = 0; first < count; first += kWideLanes) {
    const int n = static_cast<int>(std::min<std::size_t>(kWideLanes, count - first));
    WideFloats row[kWidestLanes] = {};
    for (int l = 0; l < n; ++l) {
      float sample[kWidestLanes];
      store_lanes(sample, field.at(lattice[first + l]));
      for (int i = 0; i < kWidestLanes; ++i) row[i][l] = sample[i];
    }
    const WideVectors g{row[0], row[1], row[2]};
    const WideFloats square = dot(g, g), size = square > 0.0f ? wide_root(square) : WideFloats{} + 1.0f;
    const WideVectors along = g / size;
    const WideFloats a = curvature(row + 3, along), b = curvature(row + 9, along);
    std::memcpy(of_a + first, &a, n * sizeof(float));
    std::memcpy(of_b + first, &b, n * sizeof(float));
  }
}

}  // namespace

double PatchNormals::weight_of(const ContactSet& contacts, std::size_t c) {
  return std::max(double{contacts.overlap[c]}, kLeastWeight);
}

void PatchNormals::find(const ContactSet& contacts, const ContactPair& pair, std::span<Vec3> direction,
                        std::span<Vec3> normal, bool sharp, bool brink) {
  float base = 0.0f;
  for (std::size_t c = pair.begin; c < pair.end && brink; ++c) base = std::min(base, contacts.overlap[c]);
  const std::size_t count = pair.end - pair.begin;
  weight_.resize(count), curvature_a_.resize(count), curvature_b_.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    weight_[i] = brink ? std::max(contacts.overlap[pair.begin + i] - base, static_cast<float>(kLeastWeight))
                       : static_cast<float>(weight_of(contacts, pair.begin + i));
  // The lattice is tied to the patch's own nodes: moving a scene by whole voxels changes nothing.
  Vec3i first = contacts.node[pair.begin];
  for (std::size_t c = pair.begin; c < pair.end; ++c) first = first.cwiseMin(contacts.node[c]);
  lattice_.place(std::span(contacts.point).subspan(pair.begin, count), 3.0 * pair.h, pair.h * first.cast<double>());
  average_.clear(lattice_.size());
  spread(contacts, pair.begin, count, weight_.data(), lattice_, average_);
  read_curvatures(average_, lattice_, count, curvature_a_.data(), curvature_b_.data());
  // The flatter part gives the direction; it is smoothed once more for the normal.
  direction_.clear(lattice_.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t c = pair.begin + i;
    const double ka = curvature_a_[i], kb = curvature_b_[i];
    const double pa = sharp ? ka * ka : ka, pb = sharp ? kb * kb : kb;
    const double alpha = pa + pb > 0.0 ? pa / (pa + pb) : 0.5;
    direction[c] = (1.0 - alpha) * contacts.gradient_a[c] - alpha * contacts.gradient_b[c];
    const Vec3f weighted = (double{weight_[i]} * direction[c]).cast<float>();
    direction_.add(lattice_[i], FloatLanes{weighted[0], weighted[1], weighted[2], 0.0f});
  }
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const FloatLanes d = direction_.at(lattice_[c - pair.begin]);
    const Vec3 n(d[0], d[1], d[2]);
    const double length = n.norm();
    normal[c] = length > 0.0 ? Vec3(n / length) : direction[c].normalized();
    if (!normal[c].allFinite()) normal[c] = Vec3::UnitZ();
  }
}

}  // namespace brim
