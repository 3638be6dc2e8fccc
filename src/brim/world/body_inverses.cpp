#include "brim/world/body_inverses.h"

#include <algorithm>

#include "brim/core/parallel.h"
#include "brim/core/simd.h"
#include "brim/math/block_matrix.h"

namespace brim {

namespace {

/// Velocities up to which a body's system is inverted exactly: rigid bodies, and trees of a dozen links.
constexpr std::size_t kDense = 48;

/// A factor L D Lᵀ in Eigen's format: columns of L below the diagonal.
struct Columns {
  const int *first, *row;
  const double *value, *d;
  std::size_t n;
};

/// x := L⁻ᵀ D⁻¹ L⁻¹ x. @param x  shape (n, N), row by row
template <int N>
BRIM_INLINE void solve_columns(const Columns& L, double* x) {
  for (std::size_t j = 0; j < L.n; ++j) {
    const double* own = x + j * N;
    for (int k = L.first[j]; k < L.first[j + 1]; ++k) {
      double* other = x + static_cast<std::size_t>(L.row[k]) * N;
      for (int l = 0; l < N; ++l) other[l] -= L.value[k] * own[l];
    }
  }
  for (std::size_t j = L.n; j-- > 0;) {
    double* own = x + j * N;
    double sum[N];
    for (int l = 0; l < N; ++l) sum[l] = own[l] / L.d[j];
    for (int k = L.first[j]; k < L.first[j + 1]; ++k) {
      const double* other = x + static_cast<std::size_t>(L.row[k]) * N;
      for (int l = 0; l < N; ++l) sum[l] -= L.value[k] * other[l];
    }
    for (int l = 0; l < N; ++l) own[l] = sum[l];
  }
}

BRIM_WIDE void solve_together_wide(const Columns& L, double* x) { solve_columns<BodyInverses::kTogether>(L, x); }

using Entries = std::vector<Eigen::Triplet<double>>;

/// S A S + (1 − S) of a body with a block system, S: projection off the prescribed velocities.
Entries entries_of(const BlockSystem& system) {
  const BlockMatrix& K = *system.stiffness;
  std::vector<std::uint8_t> prescribed(K.rows(), 0);
  for (const std::int32_t r : system.prescribed) prescribed[r] = 1;
  Entries entries;
  entries.reserve(9 * K.block_count());
  for (std::size_t r = 0; r < K.rows(); ++r) {
    const int row = 3 * static_cast<int>(r);
    for (std::int32_t k = K.row_first()[r]; k < K.row_first()[r + 1]; ++k) {
      const auto column = static_cast<std::size_t>(K.columns()[k]);
      if (prescribed[r] || prescribed[column]) continue;
      Mat3 block = system.stiffness_share * K.block(k).cast<double>();
      if (column == r) block.diagonal().array() += system.mass_share * system.mass[r];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) entries.emplace_back(row + i, 3 * static_cast<int>(column) + j, block(i, j));
    }
    for (int i = 0; i < 3 && prescribed[r]; ++i) entries.emplace_back(row + i, row + i, 1.0);
  }
  return entries;
}

/// The same for a body known only by its products with vectors.
Entries entries_of(const Body& body, std::size_t n) {
  Entries entries;
  std::vector<double> x(n), y(n);
  for (std::size_t j = 0; j < n; ++j) {
    std::fill(x.begin(), x.end(), 0.0), std::fill(y.begin(), y.end(), 0.0);
    x[j] = 1.0;
    body.filter(x);
    body.apply_system(x, y);
    body.filter(y);
    y[j] += 1.0;  // S A S + (1 − S)
    for (std::size_t i = 0; i < n; ++i)
      if (const double value = y[i] - x[i]; value != 0.0)
        entries.emplace_back(static_cast<int>(i), static_cast<int>(j), value);
  }
  return entries;
}

std::span<double> view(Eigen::VectorXd& x) { return {x.data(), static_cast<std::size_t>(x.size())}; }

}  // namespace

void BodyInverses::begin(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                         std::span<const std::uint8_t> wanted) {
  bodies_ = bodies;
  first_v_.assign(first_v.begin(), first_v.end());
  first_block_.assign(1, 0);
  sizes_.clear();
  sparse_.resize(bodies.size());
  parallel_for(bodies.size(), [&](std::size_t b) {
    const std::size_t n = first_v_[b + 1] - first_v_[b];
    sparse_[b].reset();
    if (wanted[b] >= 2 && n > kDense && n <= kMostFactored) factor_sparse(b, wanted[b] == 3);
  });
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (wanted[b] && !factored(b) && first_v[b + 1] - first_v[b] > kDense) {
      const std::vector<int> s = bodies[b]->block_sizes();
      sizes_.insert(sizes_.end(), s.begin(), s.end());
    }
    first_block_.push_back(sizes_.size());
  }
  diagonal_.reset(sizes_);
  dense_.assign(bodies.size(), 0);
  const Eigen::LLT<Eigen::MatrixXd> none(Eigen::MatrixXd(0, 0));  // one never computed must not be moved
  factor_.resize(bodies.size(), none), mode_.resize(bodies.size()), mode_factor_.resize(bodies.size(), none);
  parallel_for(bodies.size(), [&](std::size_t b) {
    mode_[b].resize(0, 0);
    if (!wanted[b] || factored(b)) return;
    dense_[b] = first_v_[b + 1] - first_v_[b] <= kDense;
    if (dense_[b]) return factor(b);
    bodies_[b]->add_system_diagonal(first_block_[b], diagonal_);
    find_modes(b);
  });
  diagonal_.factor();
}

void BodyInverses::factor(std::size_t body) {
  const auto n = static_cast<Eigen::Index>(first_v_[body + 1] - first_v_[body]);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd x(n), y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(n, i);
    x = unit;
    bodies_[body]->filter(view(x));
    y.setZero();
    bodies_[body]->apply_system(view(x), view(y));
    bodies_[body]->filter(view(y));
    A.col(i) = y + unit - x;  // S A S + (1 − S)
  }
  factor_[body].compute(0.5 * (A + A.transpose()));
}

void BodyInverses::factor_sparse(std::size_t body, bool shown) {
  const std::size_t n = first_v_[body + 1] - first_v_[body];
  const auto system = shown ? bodies_[body]->block_system() : std::nullopt;
  const Entries entries = system ? entries_of(*system) : entries_of(*bodies_[body], n);
  const auto size = static_cast<Eigen::Index>(n);
  Eigen::SparseMatrix<double> A(size, size);
  A.setFromTriplets(entries.begin(), entries.end());
  auto solver = std::make_unique<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>(A);
  if (solver->info() == Eigen::Success && solver->vectorD().minCoeff() > 0.0) sparse_[body] = std::move(solver);
}

void BodyInverses::find_modes(std::size_t body) {
  const auto n = static_cast<Eigen::Index>(first_v_[body + 1] - first_v_[body]);
  Eigen::MatrixXd Z(n, 6), AZ = Eigen::MatrixXd::Zero(n, 6);
  Eigen::VectorXd x(n), y(n);
  for (int i = 0; i < 6; ++i) {
    const Vec3 unit = Vec3::Unit(i % 3);
    x.setZero();
    if (!bodies_[body]->rigid_motion(i < 3 ? unit : Vec3::Zero(), i < 3 ? Vec3::Zero() : unit, view(x))) return;
    bodies_[body]->filter(view(x));
    if (!(x.norm() > 0.0)) return;
    x.normalize();
    y.setZero();
    bodies_[body]->apply_system(view(x), view(y));
    Z.col(i) = x;
    AZ.col(i) = y;
  }
  const Eigen::MatrixXd coarse = Z.transpose() * AZ;
  mode_factor_[body].compute(0.5 * (coarse + coarse.transpose()));
  if (mode_factor_[body].info() == Eigen::Success) mode_[body] = std::move(Z);
}

void BodyInverses::local(std::size_t body, std::span<const double> b, std::span<double> x) const {
  std::copy(b.begin(), b.end(), x.begin());
  bodies_[body]->filter(x);
  if (dense_[body]) {
    Eigen::Map<Eigen::VectorXd> y(x.data(), static_cast<Eigen::Index>(x.size()));
    y = factor_[body].solve(y).eval();
  } else if (factored(body)) {
    Eigen::Map<Eigen::VectorXd> y(x.data(), static_cast<Eigen::Index>(x.size()));
    y = sparse_[body]->solve(y).eval();
  } else {
    std::vector<double> rhs;
    std::size_t row = 0;
    for (std::size_t k = first_block_[body]; k < first_block_[body + 1]; ++k) {
      const auto size = static_cast<std::size_t>(sizes_[k]);
      const auto part = x.subspan(row, size);
      row += size;
      if (std::all_of(part.begin(), part.end(), [](double z) { return z == 0.0; })) continue;
      rhs.assign(part.begin(), part.end());
      diagonal_.solve_from(k, rhs, part);
    }
  }
  bodies_[body]->filter(x);
}

void BodyInverses::solve_together(std::size_t body, Together& x) const {
  const auto& solver = *sparse_[body];
  const Eigen::VectorXd d = solver.vectorD();
  const auto& L = solver.matrixL().nestedExpression();
  Together y = solver.permutationP() * x;
  solve_together_wide(
      {L.outerIndexPtr(), L.innerIndexPtr(), L.valuePtr(), d.data(), static_cast<std::size_t>(x.rows())}, y.data());
  x = solver.permutationPinv() * y;
}

Eigen::VectorXd BodyInverses::to_modes(std::size_t body, std::span<const double> b) const {
  return mode_[body].transpose() * Eigen::Map<const Eigen::VectorXd>(b.data(), static_cast<Eigen::Index>(b.size()));
}

Eigen::VectorXd BodyInverses::mode_response(std::size_t body, const Eigen::VectorXd& b) const {
  return mode_factor_[body].solve(b);
}

}  // namespace brim
