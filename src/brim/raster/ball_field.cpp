#include "brim/raster/ball_field.h"

#include <algorithm>
#include <cmath>

#include "brim/math/ramp.h"

namespace brim {

namespace {

/// Least and most share of the cells of each brick.
struct Extremes {
  std::vector<std::uint8_t> least, most;
};

Extremes extremes(const OccupancyGrid& grid, const Vec3i& bricks) {
  constexpr int kBrick = BallField::kBrick;
  const std::size_t n = static_cast<std::size_t>(bricks.x()) * bricks.y() * bricks.z();
  Extremes e{std::vector<std::uint8_t>(n, 255), std::vector<std::uint8_t>(n, 0)};
  for (int k = 0; k < bricks.z() * kBrick; ++k)
    for (int j = 0; j < bricks.y() * kBrick; ++j)
      for (int i = 0; i < bricks.x() * kBrick; ++i) {
        const bool in = i < grid.cells.x() && j < grid.cells.y() && k < grid.cells.z();
        const std::uint8_t s = in ? grid.share[grid.index(i, j, k)] : std::uint8_t{0};
        const std::size_t b =
            static_cast<std::size_t>(i / kBrick) +
            static_cast<std::size_t>(bricks.x()) *
                (static_cast<std::size_t>(j / kBrick) + static_cast<std::size_t>(bricks.y()) * (k / kBrick));
        e.least[b] = std::min(e.least[b], s);
        e.most[b] = std::max(e.most[b], s);
      }
  return e;
}

}  // namespace

BallField::BallField(const OccupancyGrid& grid, double w)
    : origin_(grid.origin), spacing_(grid.spacing), w_(std::max(w, 2.0 * grid.spacing)), cells_(grid.cells) {
  bricks_ = ((cells_.array() + kBrick - 1) / kBrick).matrix();
  const double radius = std::sqrt(0.25 * w_ * w_ / (spacing_ * spacing_) - 5.0 / 12.0);  // [cells]
  reach_ = static_cast<int>(std::ceil(radius + 0.5));
  for (int k = -reach_; k <= reach_; ++k)
    for (int j = -reach_; j <= reach_; ++j) {
      const double square = radius * radius - j * j - k * k;
      if (!(square > 0.0)) continue;
      rows_.push_back({j, k, std::sqrt(square)});
      whole_ += 2.0 * rows_.back().half;
    }
  const Extremes e = extremes(grid, bricks_);
  const int around = 1 + (reach_ - 1) / kBrick;
  brick_.reserve(e.least.size());
  for (int z = 0; z < bricks_.z(); ++z)
    for (int y = 0; y < bricks_.y(); ++y)
      for (int x = 0; x < bricks_.x(); ++x) {
        std::uint8_t least = 255, most = 0;
        for (int c = std::max(0, z - around); c <= std::min(bricks_.z() - 1, z + around); ++c)
          for (int b = std::max(0, y - around); b <= std::min(bricks_.y() - 1, y + around); ++b)
            for (int a = std::max(0, x - around); a <= std::min(bricks_.x() - 1, x + around); ++a) {
              const std::size_t n = static_cast<std::size_t>(a) +
                                    static_cast<std::size_t>(bricks_.x()) *
                                        (static_cast<std::size_t>(b) + static_cast<std::size_t>(bricks_.y()) * c);
              least = std::min(least, e.least[n]);
              most = std::max(most, e.most[n]);
            }
        if (most == 0 || least == 255) {
          brick_.push_back(most == 0 ? kEmpty : kFull);
          continue;
        }
        brick_.push_back(static_cast<std::int32_t>(value_.size() / (kSide * kSide * kSide)));
        value_.resize(value_.size() + kSide * kSide * kSide);
        const int all = fill(grid, Vec3i(x, y, z), value_.data() + value_.size() - kSide * kSide * kSide);
        if (all == 0) continue;
        brick_.back() = all > 0 ? kEmpty : kFull;
        value_.resize(value_.size() - kSide * kSide * kSide);
      }
}

int BallField::fill(const OccupancyGrid& grid, const Vec3i& brick, float* out) const {
  // The shares around the brick and, along x, their sums from the left.
  const int n = kSide + 2 * reach_;
  std::vector<float> share(static_cast<std::size_t>(n) * n * (n + 1), 0.0f), sum(share.size(), 0.0f);
  float least = 1.0f, most = 0.0f;
  const Vec3i first = kBrick * brick - Vec3i::Constant(reach_);
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j) {
      const int y = first.y() + j, z = first.z() + k;
      float* s = share.data() + static_cast<std::size_t>(n + 1) * (j + static_cast<std::size_t>(n) * k);
      float* p = sum.data() + (s - share.data());
      if (y >= 0 && z >= 0 && y < cells_.y() && z < cells_.z())
        for (int i = std::max(0, -first.x()); i < n && first.x() + i < cells_.x(); ++i)
          s[i] = grid.share[grid.index(first.x() + i, y, z)] * (1.0f / 255.0f);
      for (int i = 0; i < n; ++i) p[i + 1] = p[i] + s[i], least = std::min(least, s[i]), most = std::max(most, s[i]);
    }
  if (most == 0.0f) return 1;
  if (least == 1.0f) return -1;
  std::vector<double> filled(kSide * kSide * kSide, 0.0);
  for (const Row& r : rows_) {
    // The row of a node in column i covers [i − half, i + half]; cell c covers [c − 1/2, c + 1/2].
    const double a = reach_ + 0.5 - r.half, b = reach_ + 0.5 + r.half;
    const int ia = static_cast<int>(std::floor(a)), ib = static_cast<int>(std::floor(b));
    const auto fa = static_cast<float>(a - ia), fb = static_cast<float>(b - ib);
    for (int k = 0; k < kSide; ++k)
      for (int j = 0; j < kSide; ++j) {
        const std::size_t at =
            static_cast<std::size_t>(n + 1) * (j + reach_ + r.j + static_cast<std::size_t>(n) * (k + reach_ + r.k));
        const float *s = share.data() + at, *p = sum.data() + at;
        double* f = filled.data() + kSide * (j + kSide * k);
        for (int i = 0; i < kSide; ++i)
          f[i] += static_cast<double>((p[i + ib] - p[i + ia]) + (fb * s[i + ib] - fa * s[i + ia]));
      }
  }
  // Past the ends of the ramp by more than a float rounds, so that empty is 0 and full is 1 exactly.
  for (std::size_t i = 0; i < filled.size(); ++i)
    out[i] = static_cast<float>((1.0 + 1e-6) * ramp_inverse(std::clamp(filled[i] / whole_, 0.0, 1.0), w_));
  return 0;
}

double BallField::distance(const Vec3& p) const {
  const Vec3 x = (p - origin_) / spacing_;
  for (int a = 0; a < 3; ++a)
    if (!(x[a] >= 0.0 && x[a] < cells_[a] - 1)) return 0.5 * w_;
  const Vec3i cell = x.cast<int>();
  const Vec3i b = cell / kBrick;
  const std::int32_t place = brick(b);
  if (place < 0) return place == kEmpty ? 0.5 * w_ : -0.5 * w_;
  const Vec3i l = cell - kBrick * b;
  const Vec3 t = x - cell.cast<double>();
  const float* v = value_.data() + static_cast<std::size_t>(place) * (kSide * kSide * kSide) + l.x() +
                   kSide * (l.y() + kSide * l.z());
  const auto line = [&](const float* q) { return q[0] + t.x() * (q[1] - q[0]); };
  const auto face = [&](const float* q) { return line(q) + t.y() * (line(q + kSide) - line(q)); };
  const double near = face(v);
  return near + t.z() * (face(v + kSide * kSide) - near);
}

int BallField::uniform(const Aabb& box) const {
  const Vec3 lo = (box.lo - origin_) / spacing_, hi = (box.hi - origin_) / spacing_;
  if ((hi.array() < 0.0).any() || (lo.array() >= (cells_.cast<double>().array() - 1.0)).any()) return 1;
  const Vec3 top = (cells_ - Vec3i::Ones()).cast<double>();
  const bool inside = (lo.array() >= 0.0).all() && (hi.array() < top.array()).all();
  const Vec3i first = (lo.cwiseMax(0.0) / kBrick).cast<int>();
  const Vec3i last = (hi.cwiseMin(top) / kBrick).cast<int>();
  bool empty = true, full = inside;
  for (int z = first.z(); z <= last.z() && (empty || full); ++z)
    for (int y = first.y(); y <= last.y() && (empty || full); ++y)
      for (int x = first.x(); x <= last.x(); ++x) {
        const std::int32_t b = brick(Vec3i(x, y, z));
        empty = empty && b == kEmpty;
        full = full && b == kFull;
      }
  return empty ? 1 : full ? -1 : 0;
}

}  // namespace brim
