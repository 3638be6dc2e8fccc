#include "brim/world/sense/contact_area.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace brim {

void ContactArea::add(const Vec3& position, const Vec3& normal_force, double h) {
  if (!(normal_force.squaredNorm() > 0.0)) return;
  // Forces on opposite sides must not cancel.
  normal_ += normal_.dot(normal_force) < 0.0 ? Vec3(-normal_force) : normal_force;
  nodes_.push_back({position, h});
}

double ContactArea::take() {
  if (nodes_.empty()) return 0.0;
  // Projected along the main axis of the normal, grid nodes remain a grid; the slope corrects the area.
  Eigen::Index axis = 0;
  const double norm = normal_.norm();
  const double slope = norm > 0.0 ? normal_.cwiseAbs().maxCoeff(&axis) / norm : 1.0;
  const Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
  struct Square {
    double h;
    std::int64_t i, j;
    auto operator<=>(const Square&) const = default;
  };
  std::vector<Square> squares;
  for (const Node& n : nodes_)
    squares.push_back({n.h, std::llround(n.position[u] / n.h), std::llround(n.position[v] / n.h)});
  std::sort(squares.begin(), squares.end());
  squares.erase(std::unique(squares.begin(), squares.end()), squares.end());
  double area = 0.0;
  for (const Square& s : squares) area += s.h * s.h / slope;
  nodes_.clear();
  normal_.setZero();
  return area;
}

}  // namespace brim
