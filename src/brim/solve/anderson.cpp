#include "brim/solve/anderson.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace brim {

namespace {

/// Growth of |f| by which a step is taken back; and what keeps changes apart that rounding makes alike, over the sum of
/// their squares.
constexpr double kGrowth = 2.0, kRegular = 1e-10;

}  // namespace

Anderson::Anderson(Eigen::Index size, int memory)
    : memory_(memory), df_(size, memory), dg_(size, memory), products_(memory, memory) {}

bool Anderson::step(Eigen::VectorXd& v, const Eigen::VectorXd& g) {
  f_now_ = g - v;
  if (any_ && !(f_now_.squaredNorm() <= kGrowth * kGrowth * f_.squaredNorm())) {
    v = g_;
    forget();
    return false;
  }
  if (any_) {
    df_.col(next_) = f_now_ - f_;
    dg_.col(next_) = g - g_;
    kept_ = std::min(kept_ + 1, memory_);
    for (int i = 0; i < kept_; ++i) products_(i, next_) = products_(next_, i) = df_.col(i).dot(df_.col(next_));
    next_ = (next_ + 1) % memory_;
  }
  any_ = true;
  f_.swap(f_now_);
  v = g_ = g;
  if (kept_ == 0) return true;
  Eigen::MatrixXd normal = products_.topLeftCorner(kept_, kept_);
  normal.diagonal().array() += kRegular * normal.trace();
  const Eigen::VectorXd share = normal.llt().solve(df_.leftCols(kept_).transpose() * f_);
  if (share.allFinite()) v.noalias() -= dg_.leftCols(kept_) * share;
  return true;
}

}  // namespace brim
