#include "brim/body/meshless/held_matter.h"

#include <algorithm>
#include <map>

#include "brim/core/error.h"

namespace brim {

namespace {

/// ψ of a region, by frames of the body; empty where its frames do not span space.
ShapeFunctions region_shape(const HeldRegion& region, std::span<const Vec3> frames, std::span<const Vec3> points,
                            double reach) {
  std::vector<Vec3> held;
  for (const std::int32_t k : region.frames) held.push_back(frames[static_cast<std::size_t>(k)]);
  if (held.size() < 4) return {};
  try {
    ShapeFunctions shape = moving_least_squares(held, points, reach);
    for (std::int32_t& k : shape.rows.source) k = region.frames[static_cast<std::size_t>(k)];
    return shape;
  } catch (const InputError&) {
    return {};  // all in one plane
  }
}

void add_row(const WeightRows& rows, std::size_t s, double sign, std::map<std::int32_t, double>& chi) {
  for (std::int32_t e = rows.first[s]; e < rows.first[s + 1]; ++e)
    chi[rows.source[static_cast<std::size_t>(e)]] += sign * rows.weight[static_cast<std::size_t>(e)];
}

}  // namespace

HeldMatter::HeldMatter(std::span<const HeldRegion> regions, std::span<const Vec3> frames, double reach,
                       std::span<const Vec3> points, const ShapeFunctions& shape, std::span<const double> volume,
                       double tension) {
  std::map<std::pair<std::int32_t, std::int32_t>, double> c;
  std::vector<char> taken(points.size(), 0);
  for (const HeldRegion& region : regions) {
    std::vector<std::size_t> matter;
    std::vector<Vec3> at;
    for (std::size_t s = 0; s < points.size(); ++s)
      if (taken[s] == 0 && region.inside(points[s])) taken[s] = 1, matter.push_back(s), at.push_back(points[s]);
    const ShapeFunctions psi = region_shape(region, frames, at, reach);
    for (std::size_t i = 0; i < psi.rows.rows(); ++i) {
      std::map<std::int32_t, double> chi;
      add_row(shape.rows, matter[i], 1.0, chi);
      add_row(psi.rows, i, -1.0, chi);
      for (auto k = chi.begin(); k != chi.end(); ++k)
        for (auto l = std::next(k); l != chi.end(); ++l)
          c[{k->first, l->first}] += tension * volume[matter[i]] * k->second * l->second;
    }
  }
  for (const auto& [pair, value] : c) tie_.push_back({pair.first, pair.second, value});
}

void HeldMatter::add_pattern(BlockMatrix& matrix) const {
  std::vector<std::int32_t> nodes;
  for (const Tie& t : tie_) nodes.insert(nodes.end(), {t.k, t.l});
  matrix.add_elements(nodes, 2);
}

void HeldMatter::find_pairs(const BlockMatrix& matrix) {
  for (Tie& t : tie_) t.pair = matrix.pair(t.k, t.l);
}

void HeldMatter::add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const {
  for (const Tie& t : tie_) {
    const auto k = static_cast<std::size_t>(t.k), l = static_cast<std::size_t>(t.l);
    const Vec3 f = t.c * (x[k] - x[l]);
    force[k] += f;
    force[l] -= f;
    stiffness.add(t.pair, Mat3(t.c * Mat3::Identity()));
  }
}

double HeldMatter::energy(std::span<const Vec3> x) const {
  double sum = 0.0;
  for (const Tie& t : tie_)
    sum -= 0.5 * t.c * (x[static_cast<std::size_t>(t.k)] - x[static_cast<std::size_t>(t.l)]).squaredNorm();
  return sum;
}

}  // namespace brim
