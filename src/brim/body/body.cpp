#include "brim/body/body.h"

#include "brim/math/block_matrix.h"

namespace brim {

void Body::apply_system(std::span<const double> x, std::span<double> y) const {
  apply_mass(x, y);
  std::vector<double> t(x.size(), 0.0);
  apply_damping(x, t);
  for (std::size_t i = 0; i < t.size(); ++i) y[i] -= dt_ * t[i];
  std::fill(t.begin(), t.end(), 0.0);
  apply_stiffness(x, t);
  for (std::size_t i = 0; i < t.size(); ++i) y[i] -= dt_ * dt_ * t[i];
}

std::optional<BlockSystem> Body::block_system() const { return std::nullopt; }

void Body::precondition(std::size_t first, const BlockDiagonal& D, std::span<const double> r,
                        std::span<double> z) const {
  D.solve_from(first, r, z);
}

double Body::kinetic_energy(std::span<const double> v) const {
  std::vector<double> p(v.size(), 0.0);
  apply_mass(v, p);
  double e = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) e += 0.5 * v[i] * p[i];
  return e;
}

}  // namespace brim
