#include "brim/map/balls_map.h"

#include "brim/core/error.h"
#include "brim/map/reuse_map.h"

namespace brim {

void BallsMap::reset(std::span<const Vec3> x, std::span<const Vec3> points, std::span<const std::int32_t> ball) {
  BRIM_CHECK(points.size(), ==, ball.size());
  ball_.assign(ball.begin(), ball.end());
  arm_.resize(points.size());
  for (std::size_t p = 0; p < arm_.size(); ++p) arm_[p] = points[p] - x[static_cast<std::size_t>(ball[p])];
}

void BallsMap::apply(std::span<const double> v, std::span<Vec3> u) const {
  for (std::size_t p = 0; p < arm_.size(); ++p) {
    const double* of = v.data() + 6 * static_cast<std::size_t>(ball_[p]);
    u[p] = Eigen::Map<const Vec3>(of) + Vec3(of[3], of[4], of[5]).cross(arm_[p]);
  }
}

void BallsMap::apply_transpose(std::span<const Vec3> f, std::span<double> Q) const {
  for (std::size_t p = 0; p < arm_.size(); ++p) {
    double* of = Q.data() + 6 * static_cast<std::size_t>(ball_[p]);
    Eigen::Map<Vec3>(of) += f[p];
    Eigen::Map<Vec3>(of + 3) += arm_[p].cross(f[p]);
  }
}

bool BallsMap::append_rows(MapRows& out) const {
  for (std::size_t p = 0; p < arm_.size(); ++p) {
    out.add(2 * ball_[p], 1.0f);
    out.add(2 * ball_[p] + 1, Eigen::Matrix3f(-skew(arm_[p]).cast<float>()));
    out.end_row();
  }
  return true;
}

bool BallsMap::select(std::span<const std::uint32_t> rows, std::unique_ptr<Map>& out) const {
  auto& some = reuse_map<BallsMap>(out);
  some.ball_.resize(rows.size()), some.arm_.resize(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) some.ball_[i] = ball_[rows[i]], some.arm_[i] = arm_[rows[i]];
  return true;
}

void BallsMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  for (std::size_t p = 0; p < arm_.size(); ++p) {
    auto block = D.block(first + static_cast<std::size_t>(ball_[p]));
    const Mat3 X = skew(arm_[p]);  // u = v − X ω
    const Mat3 KX = K[p] * X;
    block.topLeftCorner<3, 3>() += K[p];
    block.topRightCorner<3, 3>() -= KX;
    block.bottomLeftCorner<3, 3>() -= KX.transpose();
    block.bottomRightCorner<3, 3>() += X.transpose() * KX;
  }
}

}  // namespace brim
