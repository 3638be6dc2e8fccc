#include "brim/body/grid_fluid/momentum_keeper.h"

#include <cmath>

namespace brim {

namespace {

/// Calls f(face, axis, cell) for every face that a cell stands at, in order; cell is the one that the marks say.
template <class F>
void for_faces_of(const MacGrid& g, std::span<const std::int32_t> piece, const F& f) {
  for (int k = 0; k <= g.n.z(); ++k)
    for (int j = 0; j <= g.n.y(); ++j)
      for (int i = 0; i <= g.n.x(); ++i)
        for (int a = 0; a < 3; ++a) {
          const Vec3i hi(i, j, k), lo = hi - Vec3i::Unit(a);
          std::int32_t p = g.inside(hi) ? piece[g.cell(hi)] : -1;
          if (p < 0 && g.inside(lo)) p = piece[g.cell(lo)];
          if (p >= 0) f(g.face(a, hi), a, p);
        }
}

}  // namespace

void MomentumKeeper::note(const WetFaces& wet, std::span<const double> mass, std::span<const double> v) {
  wet_before_.assign(wet.cell.begin(), wet.cell.end());
  mass_before_.assign(mass.begin(), mass.end());
  momentum_before_.resize(v.size());
  for (std::size_t f = 0; f < v.size(); ++f) {
    if (wet.kind[f] != WetFaces::Kind::Free) mass_before_[f] = 0.0;
    momentum_before_[f] = mass_before_[f] * v[f];
  }
}

void MomentumKeeper::label(const MacGrid& g, const WetFaces& wet) {
  piece_.assign(g.cells(), -1);
  before_.clear();
  const auto fluid = [&](int c) { return wet_before_[c] || wet.cell[c]; };
  std::int32_t pieces = 0;
  for (int start = 0; start < static_cast<int>(g.cells()); ++start) {
    if (piece_[start] >= 0 || !fluid(start)) continue;
    queue_.assign(1, start);
    piece_[start] = pieces;
    while (!queue_.empty()) {
      const int c = queue_.back();
      queue_.pop_back();
      const Vec3i at(c % g.n.x(), c / g.n.x() % g.n.y(), c / (g.n.x() * g.n.y()));
      for (int a = 0; a < 3; ++a)
        for (const int side : {-1, 1}) {
          if (at[a] + side < 0 || at[a] + side >= g.n[a]) continue;
          const int other = c + side * g.cell_stride(a);
          if (piece_[other] >= 0 || !fluid(other)) continue;
          piece_[other] = pieces;
          queue_.push_back(other);
        }
    }
    ++pieces;
  }
  before_.assign(pieces, {});
  after_.assign(pieces, {});
}

Vec3 MomentumKeeper::restore(const MacGrid& g, const WetFaces& wet, std::span<const double> mass, bool keep,
                             std::span<double> v) {
  label(g, wet);
  Sum all;
  for_faces_of(g, piece_, [&](int f, int a, std::int32_t p) {
    before_[p].momentum[a] += momentum_before_[f];
    before_[p].mass[a] += mass_before_[f];
    if (mass_before_[f] > 0.0) before_[p].energy += 0.5 * momentum_before_[f] * momentum_before_[f] / mass_before_[f];
    if (wet.kind[f] != WetFaces::Kind::Free) return;
    after_[p].momentum[a] += mass[f] * v[f];
    after_[p].mass[a] += mass[f];
    all.mass[a] += mass[f];
  });
  // What goes along with lost mass.
  for (std::size_t p = 0; p < before_.size(); ++p)
    for (int a = 0; a < 3; ++a) {
      const double m = before_[p].mass[a];
      const double share = m > 0.0 ? std::max(0.0, 1.0 - after_[p].mass[a] / m) : 0.0;
      all.momentum[a] += share * before_[p].momentum[a];
      before_[p].momentum[a] -= share * before_[p].momentum[a];
    }
  const Vec3 gone = keep ? Vec3(Vec3::Zero()) : all.momentum;
  all.momentum -= gone;
  for_faces_of(g, piece_, [&](int f, int a, std::int32_t p) {
    if (wet.kind[f] != WetFaces::Kind::Free) return;
    v[f] += (before_[p].momentum[a] - after_[p].momentum[a]) / after_[p].mass[a] + all.momentum[a] / all.mass[a];
  });
  if (gone.isZero()) keep_energy(g, wet, mass, v);
  return gone;
}

void MomentumKeeper::keep_energy(const MacGrid& g, const WetFaces& wet, std::span<const double> mass,
                                 std::span<double> v) {
  after_.assign(before_.size(), {});
  for_faces_of(g, piece_, [&](int f, int a, std::int32_t p) {
    if (wet.kind[f] != WetFaces::Kind::Free) return;
    after_[p].momentum[a] += mass[f] * v[f];
    after_[p].mass[a] += mass[f];
    after_[p].energy += 0.5 * mass[f] * v[f] * v[f];
  });
  std::vector<double> drawn(after_.size(), 1.0);
  for (std::size_t p = 0; p < after_.size(); ++p) {
    double as_one = 0.0;
    for (int a = 0; a < 3; ++a)
      if (after_[p].mass[a] > 0.0) as_one += 0.5 * after_[p].momentum[a] * after_[p].momentum[a] / after_[p].mass[a];
    const double more = after_[p].energy - as_one;
    if (after_[p].energy > before_[p].energy && more > 0.0)
      drawn[p] = std::sqrt(std::max(0.0, before_[p].energy - as_one) / more);
  }
  for_faces_of(g, piece_, [&](int f, int a, std::int32_t p) {
    if (drawn[p] == 1.0 || wet.kind[f] != WetFaces::Kind::Free) return;
    const double mean = after_[p].momentum[a] / after_[p].mass[a];
    v[f] = mean + drawn[p] * (v[f] - mean);
  });
}

void MomentumKeeper::hand_over(const MacGrid& g, const WetFaces& wet, std::span<const double> mass,
                               std::span<double> v) {
  label(g, wet);
  const auto mass_after = [&](int f) { return wet.kind[f] == WetFaces::Kind::Free ? mass[f] : 0.0; };
  // What is on its way, and the mass that takes it.
  for_faces_of(g, piece_, [&](int f, int a, std::int32_t p) {
    const double gained = mass_after(f) - mass_before_[f];
    if (gained > 0.0) {
      after_[p].mass[a] += gained;
    } else if (gained < 0.0) {
      before_[p].mass[a] -= gained;
      before_[p].momentum[a] -= gained * momentum_before_[f] / mass_before_[f];
    }
  });
  // What a piece loses beyond what it gains goes to those that gain more.
  Sum over, wanted;
  for (std::size_t p = 0; p < before_.size(); ++p)
    for (int a = 0; a < 3; ++a) {
      const double lost = before_[p].mass[a], gained = after_[p].mass[a];
      wanted.mass[a] += std::max(0.0, gained - lost);
      if (lost <= gained) continue;
      const double share = 1.0 - gained / lost;
      over.mass[a] += share * lost;
      over.momentum[a] += share * before_[p].momentum[a];
      before_[p].momentum[a] *= 1.0 - share;
    }
  for (std::size_t p = 0; p < before_.size(); ++p)
    for (int a = 0; a < 3; ++a) {
      const double more = after_[p].mass[a] - before_[p].mass[a];
      if (more > 0.0) before_[p].momentum[a] += more / wanted.mass[a] * over.momentum[a];
    }
  for_faces_of(g, piece_, [&](int f, int a, std::int32_t p) {
    const double m = mass_after(f), gained = m - mass_before_[f];
    if (gained > 0.0) v[f] = (momentum_before_[f] + gained / after_[p].mass[a] * before_[p].momentum[a]) / m;
  });
  for (std::size_t f = 0; f < v.size(); ++f)
    if (wet.kind[f] != WetFaces::Kind::Free) v[f] = 0.0;
}

}  // namespace brim
