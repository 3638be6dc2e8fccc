#include "brim/response/patch_normals.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {

constexpr double kLeastWeight = 1e-9;

}  // namespace

double PatchNormals::weight_of(const ContactSet& contacts, std::size_t c) {
  return std::max(double{contacts.overlap[c]}, kLeastWeight);
}

/// Frobenius norm of the tensor M stored at `at`, projected across n: of T M T with T = 1 − n nᵀ.
float PatchNormals::curvature(const Sample& s, int at, const Vec3f& n) {
  const Vec3f diagonal = s.segment<3>(at), off = s.segment<3>(at + 3);
  const Vec3f Mn(diagonal[0] * n[0] + off[0] * n[1] + off[1] * n[2], off[0] * n[0] + diagonal[1] * n[1] + off[2] * n[2],
                 off[1] * n[0] + off[2] * n[1] + diagonal[2] * n[2]);
  const float nMn = n.dot(Mn), all = diagonal.squaredNorm() + 2.0f * off.squaredNorm();
  return std::sqrt(std::max(0.0f, all - 2.0f * Mn.squaredNorm() + nMn * nMn));
}

void PatchNormals::find(const ContactSet& contacts, const ContactPair& pair, std::span<Vec3> direction,
                        std::span<Vec3> normal, bool sharp, bool brink) {
  float base = 0.0f;
  for (std::size_t c = pair.begin; c < pair.end && brink; ++c) base = std::min(base, contacts.overlap[c]);
  const auto weight = [&](std::size_t c) {
    return brink ? std::max(contacts.overlap[c] - base, static_cast<float>(kLeastWeight))
                 : static_cast<float>(weight_of(contacts, c));
  };
  // The lattice hangs on the patch's own nodes: moving a scene by whole voxels changes nothing.
  Vec3i first = contacts.node[pair.begin];
  for (std::size_t c = pair.begin; c < pair.end; ++c) first = first.cwiseMin(contacts.node[c]);
  lattice_.place(std::span(contacts.point).subspan(pair.begin, pair.end - pair.begin), 3.0 * pair.h,
                 pair.h * first.cast<double>());
  average_.clear(lattice_.size());
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const Vec3f &ga = contacts.gradient_a.raw(c), &gb = contacts.gradient_b.raw(c);
    Sample s;
    s.head<3>() = (ga - gb).array();
    s.segment<6>(3) = unpack_tensor_entries(ga, contacts.bend_a[c]).array();
    s.segment<6>(9) = unpack_tensor_entries(gb, contacts.bend_b[c]).array();
    s[15] = 0.0f;
    average_.add(lattice_[c - pair.begin], weight(c) * s);
  }
  // The flatter part gives the direction; the direction so found is smoothed once more for the normal.
  direction_.clear(lattice_.size());
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const Sample s = average_.at(lattice_[c - pair.begin]);
    const Vec3f n = Vec3f(s.head<3>()).normalized();
    const double ka = curvature(s, 3, n), kb = curvature(s, 9, n);
    const double pa = sharp ? ka * ka : ka, pb = sharp ? kb * kb : kb;
    const double alpha = pa + pb > 0.0 ? pa / (pa + pb) : 0.5;
    direction[c] = (1.0 - alpha) * contacts.gradient_a[c] - alpha * contacts.gradient_b[c];
    const Vec3f weighted = (double{weight(c)} * direction[c]).cast<float>();
    direction_.add(lattice_[c - pair.begin], Direction(weighted[0], weighted[1], weighted[2], 0.0f));
  }
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const Direction d = direction_.at(lattice_[c - pair.begin]);
    const Vec3 n(d[0], d[1], d[2]);
    const double length = n.norm();
    normal[c] = length > 0.0 ? Vec3(n / length) : direction[c].normalized();
    if (!normal[c].allFinite()) normal[c] = Vec3::UnitZ();
  }
}

}  // namespace brim
