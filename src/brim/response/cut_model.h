#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace brim {

inline Eigen::Matrix2d inverse_across(const Eigen::Matrix2d& m) {
  Eigen::Matrix2d r;
  r << m(1, 1), -m(0, 1), -m(1, 0), m(0, 0);
  return r / (m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0));
}

/// f(t) >= value + slope·(t − at)
struct Cut {
  Eigen::Vector2d at, slope;
  double value;
};

/// Minimum of max over cuts + ½ (t − c)·H (t − c): that of one cut, on the line where two cuts are equal, or at the
/// point where three are.
/// Tests: tests/response/cut_model_test.cpp
class CutModel {
 public:
  using Vec2 = Eigen::Vector2d;
  using Mat2 = Eigen::Matrix2d;

  explicit CutModel(const Mat2& curvature) : curvature_(curvature), inverse_(inverse_across(curvature)) {}
  /// Adds a cut; when full, it replaces the cut with the lowest prediction at the new cut's place.
  void add(const Cut& cut) {
    if (size_ == kMostCuts) {
      const auto foretells = [&](const Cut& c) { return c.value + c.slope.dot(cut.at - c.at); };
      std::size_t lowest = 0;
      for (std::size_t i = 1; i < size_; ++i)
        if (foretells(cuts_[i]) < foretells(cuts_[lowest])) lowest = i;
      cuts_[lowest] = cut;
      return;
    }
    cuts_[size_++] = cut;
  }

  /// @param from  c  @param foretold  model value at the minimum
  Vec2 least(const Vec2& from, double& foretold) const {
    Vec2 best = from;
    foretold = value(from, from);
    const auto take = [&](const Vec2& t) {
      const double v = value(t, from);
      if (v < foretold) foretold = v, best = t;
    };
    for (std::size_t i = 0; i < size_; ++i) {
      take(from - inverse_ * cuts_[i].slope);
      for (std::size_t j = 0; j < i; ++j) {
        // slope_i·t + o_i = slope_j·t + o_j
        const Vec2 across = cuts_[i].slope - cuts_[j].slope, bent = inverse_ * across;
        const double apart = across.dot(bent);
        if (!(apart > 1e-12)) continue;
        const Vec2 free = from - inverse_ * cuts_[i].slope;
        take(free - bent * ((across.dot(free) + offset(i) - offset(j)) / apart));
        for (std::size_t k = 0; k < j; ++k) {
          const Vec2 other = cuts_[i].slope - cuts_[k].slope;
          const double det = across.x() * other.y() - across.y() * other.x();
          if (std::abs(det) < 1e-9) continue;
          const double r1 = offset(j) - offset(i), r2 = offset(k) - offset(i);
          take(Vec2(r1 * other.y() - r2 * across.y(), across.x() * r2 - other.x() * r1) / det);
        }
      }
    }
    return best;
  }

 private:
  /// Maximum number of cuts: three meet at the minimum over a plane.
  static constexpr std::size_t kMostCuts = 4;

  double offset(std::size_t i) const { return cuts_[i].value - cuts_[i].slope.dot(cuts_[i].at); }
  double value(const Vec2& t, const Vec2& from) const {
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < size_; ++i) most = std::max(most, offset(i) + cuts_[i].slope.dot(t));
    return most + 0.5 * (t - from).dot(curvature_ * (t - from));
  }

  Mat2 curvature_, inverse_;
  std::array<Cut, kMostCuts> cuts_;
  std::size_t size_ = 0;
};

}  // namespace brim
