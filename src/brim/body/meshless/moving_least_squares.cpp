#include "brim/body/meshless/moving_least_squares.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

/// Frames by cubic cells, to find those near a point.
class FrameGrid {
 public:
  FrameGrid(std::span<const Vec3> frames, double cell) : frames_(frames), cell_(cell) {
    for (const Vec3& x : frames) box_.extend(x);
    n_ = ((box_.extent() / cell).array().floor().cast<int>() + 1).matrix();
    list_.resize(static_cast<std::size_t>(n_.x()) * n_.y() * n_.z());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const Vec3i c = ((frames[i] - box_.lo) / cell).cast<int>();
      list_[at(c)].push_back(static_cast<std::int32_t>(i));
    }
  }
  void near(const Vec3& x, double reach, std::vector<std::int32_t>& out) const {
    out.clear();
    const Vec3 top = (n_ - Vec3i::Ones()).cast<double>();
    const Vec3i lo = ((x - box_.lo - Vec3::Constant(reach)) / cell_).cwiseMax(0.0).cwiseMin(top).cast<int>();
    const Vec3i hi = ((x - box_.lo + Vec3::Constant(reach)) / cell_).cwiseMax(0.0).cwiseMin(top).cast<int>();
    for (int k = lo.z(); k <= hi.z(); ++k)
      for (int j = lo.y(); j <= hi.y(); ++j)
        for (int i = lo.x(); i <= hi.x(); ++i)
          for (const std::int32_t f : list_[at(Vec3i(i, j, k))])
            if ((frames_[static_cast<std::size_t>(f)] - x).squaredNorm() < reach * reach) out.push_back(f);
    std::sort(out.begin(), out.end());
  }
  double size() const { return box_.extent().norm(); }

 private:
  std::size_t at(const Vec3i& c) const {
    return static_cast<std::size_t>(c.x()) +
           static_cast<std::size_t>(n_.x()) *
               (static_cast<std::size_t>(c.y()) + static_cast<std::size_t>(n_.y()) * static_cast<std::size_t>(c.z()));
  }
  std::span<const Vec3> frames_;
  double cell_;
  Aabb box_;
  Vec3i n_;
  std::vector<std::vector<std::int32_t>> list_;
};

struct Row {
  std::vector<std::int32_t> frame;
  std::vector<double> weight;
  std::vector<Vec3> gradient;
};

/// One row; false when the frames in reach do not span space. Lengths are in units of the reach, from the point.
bool make_row(std::span<const Vec3> frames, const Vec3& x, double reach, Row& row) {
  const std::size_t n = row.frame.size();
  if (n < 4) return false;
  std::vector<Vec4> p(n);
  std::vector<double> w(n);
  std::vector<Vec3> dw(n);
  Mat4 A = Mat4::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3 d = (frames[static_cast<std::size_t>(row.frame[k])] - x) / reach;
    const double q = 1.0 - d.squaredNorm();
    p[k] << 1.0, d;
    w[k] = q * q * q;
    dw[k] = 6.0 * q * q * d;  // by x, times reach
    A += w[k] * p[k] * p[k].transpose();
  }
  // Frames in or near a plane do not say how the field changes across it.
  const Mat3 spread = A.bottomRightCorner<3, 3>() - A.block<3, 1>(1, 0) * A.block<1, 3>(0, 1) / A(0, 0);
  if (!(spread.determinant() > 1e-3 * std::pow(spread.trace() / 3.0, 3))) return false;
  const Mat4 inverse = A.inverse();
  // φ_k = c · p_k w_k with c = A⁻¹ p(0), p(0) = e₀; as x moves, p_k moves by −dx.
  const Vec4 c = inverse.col(0);
  Vec4 dc[3];
  for (int a = 0; a < 3; ++a) {
    Mat4 dA = Mat4::Zero();
    for (std::size_t k = 0; k < n; ++k) {
      Vec4 dp = Vec4::Zero();
      dp[a + 1] = -1.0;
      dA += dw[k][a] * p[k] * p[k].transpose() + w[k] * (dp * p[k].transpose() + p[k] * dp.transpose());
    }
    dc[a] = -inverse * (dA * c);
  }
  row.weight.resize(n), row.gradient.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double cp = c.dot(p[k]);
    row.weight[k] = cp * w[k];
    for (int a = 0; a < 3; ++a) row.gradient[k][a] = ((dc[a].dot(p[k]) - c[a + 1]) * w[k] + cp * dw[k][a]) / reach;
  }
  return true;
}

}  // namespace

ShapeFunctions moving_least_squares(std::span<const Vec3> frames, std::span<const Vec3> points, double reach) {
  const FrameGrid grid(frames, reach);
  std::vector<Row> made(points.size());
  parallel_for(
      points.size(),
      [&](std::size_t i) {
        double r = reach;
        for (;; r *= 1.2) {
          grid.near(points[i], r, made[i].frame);
          if (make_row(frames, points[i], r, made[i])) return;
          if (r > 4.0 * (grid.size() + reach) + (points[i] - frames[0]).norm())
            throw InputError("meshless: the frames lie in one plane; there must be four or more that span space");
        }
      },
      64);
  ShapeFunctions f;
  for (const Row& row : made) {
    f.rows.source.insert(f.rows.source.end(), row.frame.begin(), row.frame.end());
    f.rows.weight.insert(f.rows.weight.end(), row.weight.begin(), row.weight.end());
    f.gradient.insert(f.gradient.end(), row.gradient.begin(), row.gradient.end());
    f.rows.first.push_back(static_cast<std::int32_t>(f.rows.source.size()));
  }
  return f;
}

}  // namespace brim
