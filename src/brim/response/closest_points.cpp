#include "brim/response/closest_points.h"

#include <Eigen/LU>
#include <array>
#include <limits>

namespace brim {

namespace {

constexpr int kMostSteps = 100;

/// A point of the solids' difference, and the points of the two solids that it comes from.
struct Difference {
  Vec3 x, on_a, on_b;
};

/// Up to four points of the difference; the closest point to the origin of their hull.
class Simplex {
 public:
  void add(const Difference& d) { points_[size_++] = d; }
  int size() const { return size_; }
  bool has(const Vec3& x) const {
    for (int i = 0; i < size_; ++i)
      if (points_[i].x == x) return true;
    return false;
  }
  /// Keeps only the points that the closest one lies between.
  void reduce() {
    double least = std::numeric_limits<double>::infinity();
    int kept = 0;
    std::array<double, 4> weights{};
    for (int set = 1; set < 1 << size_; ++set) {
      std::array<double, 4> w{};
      if (!lies_between(set, w)) continue;
      Vec3 x = Vec3::Zero();
      for (int i = 0; i < size_; ++i) x += w[i] * points_[i].x;
      if (x.squaredNorm() < least) least = x.squaredNorm(), kept = set, weights = w;
    }
    int n = 0;
    for (int i = 0; i < size_; ++i)
      if (kept >> i & 1) points_[n] = points_[i], weight_[n++] = weights[i];
    size_ = n;
  }
  Difference closest() const {
    Difference d{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    for (int i = 0; i < size_; ++i)
      d.x += weight_[i] * points_[i].x, d.on_a += weight_[i] * points_[i].on_a, d.on_b += weight_[i] * points_[i].on_b;
    return d;
  }

 private:
  /// Weights of the point closest to the origin on the plane through a set of points; false when it is not between
  /// them.
  bool lies_between(int set, std::array<double, 4>& w) const {
    std::array<int, 4> of{};
    int n = 0;
    for (int i = 0; i < size_; ++i)
      if (set >> i & 1) of[n++] = i;
    Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
    Vec3 r = Vec3::Zero();
    for (int i = 1; i < n; ++i) {
      const Vec3 side = points_[of[i]].x - points_[of[0]].x;
      r[i - 1] = -side.dot(points_[of[0]].x);
      for (int j = 1; j < n; ++j) m(i - 1, j - 1) = side.dot(points_[of[j]].x - points_[of[0]].x);
    }
    const Vec3 t = m.fullPivLu().solve(r);
    double first = 1.0;
    for (int i = 1; i < n; ++i) {
      if (!(t[i - 1] > 0.0)) return false;
      w[of[i]] = t[i - 1], first -= t[i - 1];
    }
    w[of[0]] = first;
    return first > 0.0;
  }

  std::array<Difference, 4> points_;
  std::array<double, 4> weight_{};
  int size_ = 0;
};

}  // namespace

bool closest_points(const PlacedConvex& a, const PlacedConvex& b, const Vec3& from, double accuracy, Vec3& on_a,
                    Vec3& on_b) {
  const auto farthest = [&](const Vec3& direction) {
    const Vec3 x = a.support(-direction), y = b.support(direction);
    return Difference{x - y, x, y};
  };
  Simplex simplex;
  Vec3 way = from;
  for (int step = 0; step < kMostSteps; ++step) {
    const Difference d = farthest(way);
    if (!d.x.allFinite()) return false;
    // The distance is at least that of d along the way.
    const bool done = step > 0 && (way.norm() - d.x.dot(way) / way.norm() < accuracy || simplex.has(d.x));
    if (!done) {
      simplex.add(d);
      simplex.reduce();
    }
    const Difference closest = simplex.closest();
    on_a = closest.on_a, on_b = closest.on_b;
    if (simplex.size() == 4 || !(closest.x.norm() > 1e-3 * accuracy)) return false;
    if (done) return true;
    way = closest.x;
  }
  return true;
}

}  // namespace brim
