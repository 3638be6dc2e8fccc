// Calls of the author's functions, whose errors name the body, the function, the time and the coordinates; and what
// depends on their reading the time.
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "brim/body/own/own_body.h"
#include "brim/core/author_error.h"
#include "brim/core/error.h"

namespace brim {

namespace {

/// Coordinates shown in a message, at most.
constexpr std::size_t kShown = 12;

std::string text_of(std::span<const double> q) {
  std::string text;
  for (std::size_t i = 0; i < std::min(q.size(), kShown); ++i) text += fmt::format("{}{:.6g}", i > 0 ? ", " : "", q[i]);
  return "(" + text + (q.size() > kShown ? ", ...)" : ")");
}

std::string text_of(const Vec3& x) { return text_of(std::span<const double>(x.data(), 3)); }

bool same_bits(const void* a, const void* b, std::size_t bytes) { return std::memcmp(a, b, bytes) == 0; }

}  // namespace

void OwnBody::refuse(const char* function, Coordinates q, const std::string& what) const {
  throw InputError(fmt::format("body '{}': {} {}, at {:.6g} s and q = {}", name(), function, what, now_, text_of(q)));
}

template <class F>
auto OwnBody::ask(const char* function, Coordinates q, const F& f) const {
  return call_author(f, [&](const std::exception& e) {
    if (!errors_are_named()) refuse(function, q, fmt::format("raised \"{}\"", e.what()));
  });
}

void OwnBody::ask_deform(Coordinates q, std::span<const Vec3> X, std::span<Vec3> x) const {
  ask("deform(q, X)", q, [&] { deform_all(q, X, x); });
  for (std::size_t p = 0; p < X.size(); ++p)
    if (!x[p].allFinite())
      refuse("deform(q, X)", q, fmt::format("gave {} for X = {}; must be finite", text_of(x[p]), text_of(X[p])));
}

void OwnBody::ask_inverse_deform(Coordinates q, std::span<const Vec3> x, std::span<Vec3> X) const {
  ask("inverse_deform(q, x)", q, [&] { inverse_deform_all(q, x, X); });
  for (std::size_t p = 0; p < x.size(); ++p)
    if (!X[p].allFinite())
      refuse("inverse_deform(q, x)", q,
             fmt::format("gave {} for x = {}; must be finite", text_of(X[p]), text_of(x[p])));
}

void OwnBody::ask_jacobian(Coordinates q, std::span<const Vec3> X, DenseMap& J) const {
  ask("jacobian(q, X)", q, [&] { jacobian_all(q, X, J); });
  for (std::size_t p = 0; p < X.size(); ++p) {
    if (J.row(p).allFinite()) continue;
    const Jacobian given = J.row(p);
    Eigen::Index i = 0;
    while (given.col(i).allFinite()) ++i;
    refuse(
        "jacobian(q, X)", q,
        fmt::format("gave {} in column {} for X = {}; must be finite", text_of(Vec3(given.col(i))), i, text_of(X[p])));
  }
}

double OwnBody::ask_distance(Coordinates q, const Vec3& x) const {
  const double d = ask("distance(q, x)", q, [&] { return distance(q, x); });
  if (std::isnan(d)) refuse("distance(q, x)", q, fmt::format("gave nan for x = {}; must be a number", text_of(x)));
  return d;
}

double OwnBody::ask_energy(Coordinates q) const {
  const double E = ask("energy(q)", q, [&] { return energy(q); });
  if (!std::isfinite(E)) refuse("energy(q)", q, fmt::format("gave {}; must be finite", E));
  return E;
}

Eigen::VectorXd OwnBody::ask_force(Coordinates q) const {
  Eigen::VectorXd f = ask("energy_force(q)", q, [&] { return energy_force(q); });
  if (f.size() != static_cast<Eigen::Index>(q.size()))
    refuse("energy_force(q)", q,
           fmt::format("gave {} numbers; must be {}, one for each coordinate", f.size(), q.size()));
  for (Eigen::Index i = 0; i < f.size(); ++i)
    if (!std::isfinite(f[i]))
      refuse("energy_force(q)", q, fmt::format("gave {} for coordinate {}; must be finite", f[i], i));
  return f;
}

bool OwnBody::changes(double from, double to, std::span<const double> q) {
  const std::vector<double> still(v_size(), 0.0);
  Environment weightless;
  weightless.gravity.setZero();
  const auto forces = [&] {
    std::vector<double> Q(v_size(), 0.0);
    add_forces(weightless, Q);
    return Q;
  };
  if (now_ != from || v_ != still || !std::equal(q.begin(), q.end(), q_.begin(), q_.end())) update(from, q, still);
  const std::vector<double> before = forces();
  const std::vector<Vec3> shape = vertex_;
  update(to, q, still);
  const std::vector<double> after = forces();
  return !same_bits(before.data(), after.data(), before.size() * sizeof(double)) ||
         !same_bits(shape.data(), vertex_.data(), shape.size() * sizeof(Vec3));
}

}  // namespace brim
