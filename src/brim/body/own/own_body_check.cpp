#include "brim/body/own/own_body_check.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "brim/body/own/lost_coordinates.h"
#include "brim/core/error.h"
#include "brim/math/splitmix.h"

namespace brim {

namespace {

/// States that are checked: the start, and random ones that move matter by up to this share of its extent.
constexpr int kStates = 4;
constexpr double kNearStart = 0.02;
/// Places of the matter and of the surface that are checked, at most.
constexpr std::size_t kPlaces = 200;
/// Allowed errors: of forces, motions and inverses, as shares; of the surface, [voxels]; of the slope of distance, [-].
constexpr double kShare = 0.01, kSurface = 0.25, kSlope = 0.2;
/// [-] share of places that may be off where surfaces are concave or have edges.
constexpr double kFew = 0.25;
/// [voxels] half a ramp (WorldOptions::ramp_voxels): so far distance is read.
constexpr double kHalfRamp = 1.5;
/// Asymmetry and negative part of a mass matrix that are rounding.
constexpr double kMassRounding = 1e-9;

std::string vector_text(const Vec3& x) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", x.x(), x.y(), x.z()); }

template <class T>
std::vector<T> evenly(const std::vector<T>& from) {
  std::vector<T> some;
  const std::size_t n = std::min(kPlaces, from.size());
  for (std::size_t k = 0; k < n; ++k) some.push_back(from[k * from.size() / n]);
  return some;
}

double median(std::vector<double> x) {
  std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
  return x[x.size() / 2];
}

}  // namespace

class OwnBodyCheck {
 public:
  OwnBodyCheck(const OwnBody& body, unsigned seed) : b_(body), state_(seed) {
    Aabb box;
    for (const Vec3& X : body.model_.surface.vertices) box.extend(X);
    extent_ = box.extent().maxCoeff();
    h_ = body.part_.voxel_size;
    matter_ = evenly(body.piece_);
    triangles_ =
        evenly(std::vector<Triangle>(body.model_.surface.triangles.begin(), body.model_.surface.triangles.end()));
  }

  std::vector<std::string> findings() {
    std::string force, jacobian, inverse, distance, mass;
    for (int state = 0; state < kStates; ++state) {
      q_ = b_.model_.q;
      if (state > 0)
        for (std::size_t i = 0; i < q_.size(); ++i) q_[i] += kNearStart * b_.scale_[i] * random();
      const auto run = [&](std::string& text, std::string (OwnBodyCheck::*check)() const) {
        if (!text.empty()) return;
        try {
          text = (this->*check)();
          if (!text.empty()) text = fmt::format("body '{}': {}, at q = {}", b_.name(), text, coordinates_text());
        } catch (const InputError& e) {
          text = e.what();
        }
      };
      run(jacobian, &OwnBodyCheck::jacobian);
      run(inverse, &OwnBodyCheck::inverse);
      run(distance, &OwnBodyCheck::distance);
      run(force, &OwnBodyCheck::force);
      run(mass, &OwnBodyCheck::mass);
    }
    std::vector<std::string> found;
    for (const std::string& text : {jacobian, inverse, distance, force, mass})
      if (!text.empty() && std::find(found.begin(), found.end(), text) == found.end()) found.push_back(text);
    return found;
  }

 private:
  /// From −1 to 1.
  double random() { return std::ldexp(static_cast<double>(next_scattered(state_) >> 11), -52) - 1.0; }

  std::string coordinates_text() const {
    std::string text;
    for (std::size_t i = 0; i < std::min<std::size_t>(q_.size(), 12); ++i)
      text += fmt::format("{}{:.6g}", i > 0 ? ", " : "(", q_[i]);
    return text + (q_.size() > 12 ? ", ...)" : ")");
  }

  std::vector<double> moved(std::size_t i, double d) const {
    std::vector<double> q = q_;
    q[i] += d;
    return q;
  }

  std::string force() const {
    const Eigen::VectorXd f = b_.ask_force(q_);
    const double E = b_.ask_energy(q_), rounding = 16.0 * std::numeric_limits<double>::epsilon() * std::abs(E);
    const auto scale = [&](std::size_t i) { return b_.scale_[i]; };
    // Differences of three sizes, central and of either side: an energy may be curved on a small scale, or have a kink.
    std::vector<std::vector<double>> slopes(q_.size());
    double largest = 0.0;
    for (std::size_t i = 0; i < q_.size(); ++i) {
      for (const double relative : {1e-3, 1e-4, 1e-5}) {
        const double d = relative * scale(i), up = b_.ask_energy(moved(i, d)), down = b_.ask_energy(moved(i, -d));
        slopes[i].insert(slopes[i].end(), {(up - down) / (2.0 * d), (up - E) / d, (E - down) / d});
      }
      largest = std::max(
          {largest, std::abs(f[static_cast<Eigen::Index>(i)]) * scale(i), std::abs(slopes[i].front()) * scale(i)});
    }
    for (std::size_t i = 0; i < q_.size(); ++i) {
      const double given = f[static_cast<Eigen::Index>(i)], allowed = (kShare * largest + rounding / 1e-3) / scale(i);
      double miss = std::numeric_limits<double>::infinity();
      for (const double slope : slopes[i]) miss = std::min(miss, std::abs(given + slope));
      if (!(miss <= allowed))
        return fmt::format(
            "force of coordinate {} is {:.6g}, but minus the derivative of energy(q) is {:.6g} (allowed: {:.2g} apart)",
            i, given, -slopes[i].front(), allowed);
    }
    return "";
  }

  std::string jacobian() const {
    const std::size_t n = q_.size(), m = matter_.size();
    DenseMap J;
    J.reset(m, n);
    b_.ask_jacobian(q_, matter_, J);
    std::vector<Vec3> x(m), up(m), down(m);
    b_.ask_deform(q_, matter_, x);
    for (std::size_t i = 0; i < n; ++i) {
      const double d = b_.place_step(i), allowed = kShare * extent_ / b_.scale_[i];
      b_.ask_deform(moved(i, d), matter_, up);
      b_.ask_deform(moved(i, -d), matter_, down);
      for (std::size_t p = 0; p < m; ++p) {
        const Vec3 given = J.row(p).col(static_cast<Eigen::Index>(i)), found = (up[p] - down[p]) / (2.0 * d);
        const double miss = std::min(
            {(given - found).norm(), (given - (up[p] - x[p]) / d).norm(), (given - (x[p] - down[p]) / d).norm()});
        if (!(miss <= allowed))
          return fmt::format(
              "jacobian at X = {} has {} for coordinate {}, but the derivative of deform(q, X) is {} (allowed: {:.2g} "
              "apart)",
              vector_text(matter_[p]), vector_text(given), i, vector_text(found), allowed);
      }
    }
    return "";
  }

  std::string inverse() const {
    std::vector<Vec3> x(matter_.size()), X(matter_.size());
    b_.ask_deform(q_, matter_, x);
    b_.ask_inverse_deform(q_, x, X);
    for (std::size_t p = 0; p < X.size(); ++p)
      if (!((X[p] - matter_[p]).norm() <= kShare * extent_))
        return fmt::format("inverse_deform of the place of X = {} is {} (allowed: {:.2g} m apart)",
                           vector_text(matter_[p]), vector_text(X[p]), kShare * extent_);
    return "";
  }

  std::string distance() const {
    const std::vector<Vec3>& vertices = b_.model_.surface.vertices;
    std::vector<Vec3> surface(vertices.size()), inside(matter_.size());
    b_.ask_deform(q_, vertices, surface);
    b_.ask_deform(q_, matter_, inside);
    const auto at = [&](const Vec3& x) { return b_.ask_distance(q_, x); };
    for (const Vec3& x : evenly(surface))
      if (const double d = at(x); !(std::abs(d) <= kSurface * h_))
        return fmt::format(
            "distance at x = {}, a vertex of the surface, is {:.4g} m; must be 0 to a quarter of a voxel ({:.2g} m)",
            vector_text(x), d, kSurface * h_);
    std::size_t tried = 0, wrong = 0;
    Vec3 where = Vec3::Zero();
    double value = 0.0;
    for (const Vec3& x : inside)
      if (const double d = at(x); !(d <= kSurface * h_)) ++wrong, where = x, value = d;
    if (static_cast<double>(wrong) > kFew * static_cast<double>(inside.size()))
      return fmt::format("distance at x = {}, where there is matter, is {:.4g} m; must be negative there",
                         vector_text(where), value);
    wrong = 0;
    std::vector<double> near, far;
    for (const Triangle& t : triangles_) {
      const Vec3 &a = surface[t[0]], &b = surface[t[1]], &c = surface[t[2]];
      const Vec3 middle = (a + b + c) / 3.0, n = (b - a).cross(c - a).normalized();
      if (!n.allFinite()) continue;
      const double d = at(middle), out = at(middle + h_ * n);
      ++tried;
      if (!(out > 0.0)) ++wrong, where = middle + h_ * n, value = out;
      near.push_back((at(middle + 0.5 * h_ * n) - d) / (0.5 * h_));
      far.push_back((at(middle + kHalfRamp * h_ * n) - d) / (kHalfRamp * h_));
    }
    if (tried == 0) return "";
    if (static_cast<double>(wrong) > kFew * static_cast<double>(tried))
      return fmt::format("distance at x = {}, a voxel outside of the surface, is {:.4g} m; must be positive there",
                         vector_text(where), value);
    if (const double slope = median(near); !(std::abs(slope - 1.0) <= kSlope))
      return fmt::format(
          "distance grows by {:.3g} m per metre outwards at the surface; must be 1 to {} (divide by the length of the "
          "gradient)",
          slope, kSlope);
    if (const double slope = median(far); !(std::abs(slope - 1.0) <= kSlope))
      return fmt::format(
          "distance saturates: it grows by {:.3g} m per metre within {} voxels outside of the surface, as far as "
          "contact reads it; must be 1 to {}",
          slope, kHalfRamp, kSlope);
    // Farther away its sign is enough, but it must be a number.
    Aabb box;
    for (const Vec3& x : surface) box.extend(x);
    box = box.inflated(box.extent().maxCoeff());
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 x(corner & 1 ? box.hi.x() : box.lo.x(), corner & 2 ? box.hi.y() : box.lo.y(),
                   corner & 4 ? box.hi.z() : box.lo.z());
      if (const double d = at(x); !(d > 0.0))
        return fmt::format("distance at x = {}, far outside of the surface, is {:.4g} m; must be positive there",
                           vector_text(x), d);
    }
    return "";
  }

  std::string mass() const {
    const auto n = static_cast<Eigen::Index>(q_.size());
    // As the solve sees it, in units that move matter by its extent.
    Eigen::MatrixXd A(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      std::vector<double> e(q_.size(), 0.0), Me(q_.size(), 0.0);
      e[static_cast<std::size_t>(i)] = b_.scale_[static_cast<std::size_t>(i)];
      b_.apply_mass(e, Me);
      for (Eigen::Index k = 0; k < n; ++k)
        A(k, i) = Me[static_cast<std::size_t>(k)] * b_.scale_[static_cast<std::size_t>(k)];
    }
    if (!((A - A.transpose()).norm() <= kMassRounding * A.norm()))
      return "the mass matrix (apply_mass) is not symmetric";
    const Eigen::VectorXd eigen = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A).eigenvalues();
    if (!(eigen[0] >= -kMassRounding * A.norm()))
      return fmt::format("the mass matrix (apply_mass) is not positive: an eigenvalue is {:.3g} of the largest",
                         eigen[0] / eigen[n - 1]);
    DenseMap J;
    J.reset(b_.piece_.size(), q_.size());
    b_.ask_jacobian(q_, b_.piece_, J);
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t p = 0; p < b_.piece_.size(); ++p) M += b_.piece_mass_[p] * J.row(p).transpose() * J.row(p);
    return lost_text(lost_coordinates(M, b_.K_));
  }

 public:
  static std::string lost_text(const std::vector<Eigen::Index>& lost) {
    if (lost.empty()) return "";
    std::string list;
    for (std::size_t k = 0; k < lost.size(); ++k)
      list += (k == 0 ? "" : k + 1 == lost.size() ? " and " : ", ") + std::to_string(lost[k]);
    if (lost.size() == 1)
      return fmt::format("coordinate {} has no effect: it moves no matter, and the energy does not depend on it", list);
    return fmt::format(
        "coordinates {} have no effects of their own: together they can change without moving matter or changing the "
        "energy; leave out what the others can do (the mass matrix is singular)",
        list);
  }

 private:
  const OwnBody& b_;
  std::uint64_t state_;  // of the random numbers
  std::vector<double> q_;
  double extent_ = 0.0, h_ = 0.0;
  std::vector<Vec3> matter_;         // [m] at rest
  std::vector<Triangle> triangles_;  // of the surface
};

std::vector<std::string> check_own_body(const OwnBody& body, unsigned seed) {
  return OwnBodyCheck(body, seed).findings();
}

void OwnBody::check_start() const {
  ask_distance(q_, vertex_.front());
  Vec3 X;
  ask_inverse_deform(q_, {&vertex_.front(), 1}, {&X, 1});
  if (const std::string lost = OwnBodyCheck::lost_text(lost_coordinates(M_, K_)); !lost.empty())
    throw InputError(fmt::format("body '{}': {}", name(), lost));
}

}  // namespace brim
