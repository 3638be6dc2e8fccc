#include "brim/world/sense/contact_area.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

namespace brim {

namespace {

/// Load of a square, relative to that typical of its patch, from which it counts in full.
constexpr double kFullShare = 0.05;

/// A square of the projected grid with the sum of its nodes' normal forces.
struct Square {
  double h;
  std::int64_t i, j;
  double force;
  auto place() const { return std::tuple(h, i, j); }
};

/// Sorts the squares and joins those of one place.
void join_equal(std::vector<Square>& squares) {
  std::stable_sort(squares.begin(), squares.end(),
                   [](const Square& a, const Square& b) { return a.place() < b.place(); });
  std::size_t n = 0;
  for (const Square& s : squares) {
    if (n > 0 && squares[n - 1].place() == s.place())
      squares[n - 1].force += s.force;
    else
      squares[n++] = s;
  }
  squares.resize(n);
}

/// Calls f with the numbers of the squares of each patch: those that touch each other at a side or corner.
template <class F>
void for_patches(const std::vector<Square>& squares, const F& f) {
  std::vector<std::uint8_t> taken(squares.size(), 0);
  std::vector<std::size_t> patch;
  for (std::size_t first = 0; first < squares.size(); ++first) {
    if (taken[first] != 0) continue;
    patch.assign(1, first), taken[first] = 1;
    for (std::size_t k = 0; k < patch.size(); ++k) {
      const Square s = squares[patch[k]];
      for (std::int64_t i = s.i - 1; i <= s.i + 1; ++i) {
        const auto row = std::tuple(s.h, i, s.j - 1);
        auto at = std::lower_bound(squares.begin(), squares.end(), row,
                                   [](const Square& a, const auto& place) { return a.place() < place; });
        for (; at != squares.end() && at->h == s.h && at->i == i && at->j <= s.j + 1; ++at)
          if (const auto n = static_cast<std::size_t>(at - squares.begin()); taken[n] == 0)
            taken[n] = 1, patch.push_back(n);
      }
    }
    f(patch);
  }
}

}  // namespace

void ContactArea::add(const Vec3& position, const Vec3& normal_force, double h) {
  if (!(normal_force.squaredNorm() > 0.0)) return;
  // Forces on opposite sides must not cancel.
  normal_ += normal_.dot(normal_force) < 0.0 ? Vec3(-normal_force) : normal_force;
  nodes_.push_back({position, h, normal_force.norm()});
}

double ContactArea::take() {
  if (nodes_.empty()) return 0.0;
  // Projected along the main axis of the normal, grid nodes remain a grid; the slope corrects the area.
  Eigen::Index axis = 0;
  const double norm = normal_.norm();
  const double slope = norm > 0.0 ? normal_.cwiseAbs().maxCoeff(&axis) / norm : 1.0;
  const Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::vector<Square> squares;
  for (const Node& n : nodes_)
    squares.push_back({n.h, std::llround(n.position[u] / n.h), std::llround(n.position[v] / n.h), n.force});
  join_equal(squares);
  double area = 0.0;
  for_patches(squares, [&](const std::vector<std::size_t>& patch) {
    double sum = 0.0, sum_of_squares = 0.0;
    for (const std::size_t k : patch) sum += squares[k].force, sum_of_squares += squares[k].force * squares[k].force;
    const double full = kFullShare * sum_of_squares / sum;
    for (const std::size_t k : patch) {
      const Square& s = squares[k];
      area += s.h * s.h / slope * (s.force < full ? s.force / full : 1.0);
    }
  });
  nodes_.clear();
  normal_.setZero();
  return area;
}

}  // namespace brim
