#include "brim/body/grid_fluid/grid_poisson.h"

#include <algorithm>
#include <cmath>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/core/simd.h"
#include "brim/core/stop.h"

namespace brim {

namespace {

/// Rows that a thread takes at once; sums are made block by block, whatever the number of threads.
constexpr std::size_t kRowsOfSum = 256;

struct PaddedMatrix {
  const double *d, *x, *y, *z;
  std::size_t row, plane;
};

BRIM_INLINE double sum_of(const Lanes& s) { return (s[0] + s[2]) + (s[1] + s[3]); }
BRIM_INLINE Lanes larger(const Lanes& a, const Lanes& b) { return a > b ? a : b; }

/// y = A x. @return x · y
BRIM_WIDE double apply_rows(const PaddedMatrix& a, std::span<const std::size_t> rows, const double* x, double* y) {
  Lanes sum = {};
  for (const std::size_t first : rows)
    for (std::size_t c = first; c < first + a.row; c += kLanes) {
      const Lanes now = load_lanes(x + c);
      const Lanes sx = load_lanes(a.x + c - 1) * load_lanes(x + c - 1) + load_lanes(a.x + c) * load_lanes(x + c + 1);
      const Lanes sy =
          load_lanes(a.y + c - a.row) * load_lanes(x + c - a.row) + load_lanes(a.y + c) * load_lanes(x + c + a.row);
      const Lanes sz = load_lanes(a.z + c - a.plane) * load_lanes(x + c - a.plane) +
                       load_lanes(a.z + c) * load_lanes(x + c + a.plane);
      const Lanes out = load_lanes(a.d + c) * now - ((sx + sy) + sz);
      store_lanes(y + c, out);
      sum += now * out;
    }
  return sum_of(sum);
}

/// x += step p, r -= step y. @return the largest of |r|
BRIM_WIDE double advance_rows(std::span<const std::size_t> rows, std::size_t row, double step, const double* p,
                              const double* y, double* x, double* r) {
  Lanes most = {};
  for (const std::size_t first : rows)
    for (std::size_t c = first; c < first + row; c += kLanes) {
      store_lanes(x + c, load_lanes(x + c) + step * load_lanes(p + c));
      const Lanes left = load_lanes(r + c) - step * load_lanes(y + c);
      store_lanes(r + c, left);
      most = larger(most, larger(left, -left));
    }
  return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

/// b = s r over `most`
BRIM_WIDE void scale_rows(std::span<const std::size_t> rows, std::size_t row, double inverse, const double* r,
                          const float* s, float* b) {
  for (const std::size_t first : rows)
    for (std::size_t c = first; c < first + row; c += kLanes)
      store_lanes(b + c, __builtin_convertvector(inverse * load_lanes(r + c), FloatLanes) * load_lanes(s + c));
}

/// @return Σ r s z
BRIM_WIDE double product_rows(std::span<const std::size_t> rows, std::size_t row, const double* r, const float* s,
                              const float* z) {
  Lanes sum = {};
  for (const std::size_t first : rows)
    for (std::size_t c = first; c < first + row; c += kLanes)
      sum += load_lanes(r + c) * (to_double(load_lanes(s + c)) * to_double(load_lanes(z + c)));
  return sum_of(sum);
}

/// p = most s z + ratio p
BRIM_WIDE void turn_rows(std::span<const std::size_t> rows, std::size_t row, double ratio, double most, const float* s,
                         const float* z, double* p) {
  for (const std::size_t first : rows)
    for (std::size_t c = first; c < first + row; c += kLanes)
      store_lanes(p + c,
                  most * (to_double(load_lanes(s + c)) * to_double(load_lanes(z + c))) + ratio * load_lanes(p + c));
}

/// f(rows) over blocks of rows, its numbers block by block into `part`.
template <class F>
void fold_rows(std::span<const std::size_t> rows, std::vector<double>& part, const F& f) {
  part.assign((rows.size() + kRowsOfSum - 1) / kRowsOfSum, 0.0);
  parallel_blocks(rows.size(), kRowsOfSum, [&](std::size_t begin, std::size_t end) {
    part[begin / kRowsOfSum] = f(rows.subspan(begin, end - begin));
  });
}

double sum_of(const std::vector<double>& part) {
  double s = 0.0;
  for (const double x : part) s += x;
  return s;
}

double largest_of(const std::vector<double>& part) {
  double most = 0.0;
  for (const double x : part) most = std::max(most, x);
  return most;
}

}  // namespace

void GridPoisson::finish() {
  multigrid_.set(matrix_);
  const PaddedBox& box = multigrid_.box();
  for (std::vector<double>* array : {&diagonal_, &coupling_[0], &coupling_[1], &coupling_[2], &x_, &r_, &p_, &y_})
    array->assign(box.size, 0.0);
  known_.clear();
  box.for_cells([&](std::size_t at, std::size_t c) {
    diagonal_[at] = matrix_.diagonal[c];
    for (std::size_t a = 0; a < 3; ++a) coupling_[a][at] = matrix_.coupling[a][c];
    if (matrix_.diagonal[c] > 0.0) known_.push_back({static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(c)});
  });
}

/// y = A x. @return x · y
double GridPoisson::apply(std::span<const double> x, std::span<double> y) {
  const PaddedBox& box = multigrid_.box();
  const PaddedMatrix a = {diagonal_.data(), coupling_[0].data(), coupling_[1].data(), coupling_[2].data(), box.row,
                          box.plane};
  fold_rows(multigrid_.rows(), part_, [&](auto rows) { return apply_rows(a, rows, x.data(), y.data()); });
  return sum_of(part_);
}

/// @return the largest residual
double GridPoisson::advance(double step) {
  fold_rows(multigrid_.rows(), part_, [&](auto rows) {
    return advance_rows(rows, multigrid_.box().row, step, p_.data(), y_.data(), x_.data(), r_.data());
  });
  return largest_of(part_);
}

/// z = M⁻¹ r. @param most  the largest of |r|: the cycle gets numbers around one @return r · z
double GridPoisson::precondition(double most) {
  const std::size_t row = multigrid_.box().row;
  const float* scale = multigrid_.scale().data();
  float* b = multigrid_.scaled_rhs().data();
  fold_rows(multigrid_.rows(), part_, [&](auto rows) {
    scale_rows(rows, row, 1.0 / most, r_.data(), scale, b);
    return 0.0;
  });
  const float* z = multigrid_.cycle().data();
  fold_rows(multigrid_.rows(), part_, [&](auto rows) { return product_rows(rows, row, r_.data(), scale, z); });
  return most * sum_of(part_);
}

/// p = z + ratio p
void GridPoisson::turn(double ratio, double most) {
  fold_rows(multigrid_.rows(), part_, [&](auto rows) {
    turn_rows(rows, multigrid_.box().row, ratio, most, multigrid_.scale().data(), multigrid_.found().data(), p_.data());
    return 0.0;
  });
}

void GridPoisson::multiply(std::span<const double> x, std::span<double> y) {
  for (const auto [at, c] : known_) p_[at] = x[c];
  apply(p_, y_);
  for (const auto [at, c] : known_) y[c] = y_[at];
}

void GridPoisson::cycle(std::span<const double> r, std::span<double> z) {
  double most = 0.0;
  for (const auto [at, c] : known_) {
    r_[at] = r[c];
    most = std::max(most, std::abs(r[c]));
  }
  if (most > 0.0) precondition(most);
  const auto scale = multigrid_.scale(), found = multigrid_.found();
  for (const auto [at, c] : known_) z[c] = most > 0.0 ? most * double{scale[at]} * double{found[at]} : 0.0;
}

int GridPoisson::solve(std::span<const double> b, double tolerance, int max_iterations, std::span<double> x) {
  BRIM_CHECK(b.size(), ==, matrix_.diagonal.size());
  BRIM_CHECK(x.size(), ==, matrix_.diagonal.size());
  for (const auto [at, c] : known_) x_[at] = x[c];
  apply(x_, y_);
  double most = 0.0;
  for (const auto [at, c] : known_) {
    r_[at] = b[c] - y_[at];
    most = std::max(most, std::abs(r_[at]));
  }
  int iterations = 0;
  double rz = 0.0;
  while (most > tolerance && iterations < max_iterations) {
    check_stop();
    const double next = precondition(most);
    if (!(next > 0.0) || !std::isfinite(next)) break;
    turn(iterations > 0 ? next / rz : 0.0, most);
    rz = next;
    const double curvature = apply(p_, y_);
    if (!(curvature > 0.0)) break;
    most = advance(rz / curvature);
    ++iterations;
  }
  std::ranges::fill(x, 0.0);
  for (const auto [at, c] : known_) x[c] = x_[at];
  return iterations;
}

}  // namespace brim
