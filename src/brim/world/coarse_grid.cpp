#include "brim/world/coarse_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "brim/core/parallel.h"
#include "brim/world/coarse_grid_lanes.h"

namespace brim {

namespace {

/// Maximum number of grid cells: for bodies far from each other cells get wider.
constexpr std::size_t kGridCells = std::size_t{1} << 20;
/// Mean length of the edges between coupled nodes, and their largest extent along each axis.
struct Edges {
  double sum = 0.0;
  std::size_t count = 0;
  Vec3 most = Vec3::Zero();

  void add(const Edges& e) { sum += e.sum, count += e.count, most = most.cwiseMax(e.most); }
};

Edges edges_of(const BlockSystem& s) {
  constexpr std::size_t kRows = 4096;
  const std::size_t n = s.stiffness->rows();
  const auto first = s.stiffness->row_first(), column = s.stiffness->columns();
  std::vector<Edges> part((n + kRows - 1) / kRows);
  parallel_blocks(n, kRows, [&](std::size_t begin, std::size_t end) {
    Edges& e = part[begin / kRows];
    for (std::size_t r = begin; r < end; ++r)
      for (std::int32_t k = first[r]; k < first[r + 1] && static_cast<std::size_t>(column[k]) < r; ++k) {
        const Vec3 d = s.place[r] - s.place[column[k]];
        e.sum += d.norm(), ++e.count;
        e.most = e.most.cwiseMax(d.cwiseAbs());
      }
  });
  Edges all;
  for (const Edges& e : part) all.add(e);
  return all;
}

}  // namespace

std::size_t CoarseGrid::dense_cell(const Place& p) const {
  return static_cast<std::size_t>(p[0]) +
         static_cast<std::size_t>(cells_[0]) *
             (static_cast<std::size_t>(p[1]) + static_cast<std::size_t>(cells_[1]) * static_cast<std::size_t>(p[2]));
}

void CoarseGrid::begin(std::span<const Member> members, std::size_t velocities, double cell_edges) {
  node_of_.assign(velocities, -1);
  lay(members, cell_edges);
  sort_nodes(members);
  number_corners();
  sum_bodies(members);
}

void CoarseGrid::lay(std::span<const Member> members, double cell_edges) {
  Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity()), hi = -lo;
  Edges edges;
  for (const Member& m : members) {
    for (const Vec3& x : m.system.place) lo = lo.cwiseMin(x), hi = hi.cwiseMax(x);
    edges.add(edges_of(m.system));
  }
  origin_ = lo;
  const Vec3 extent = hi - lo;
  double width = cell_edges * edges.sum / static_cast<double>(std::max<std::size_t>(edges.count, 1));
  for (std::size_t cells = kGridCells + 1; cells > kGridCells; width *= 1.25) {
    cells = 1;
    for (int a = 0; a < 3; ++a) {
      // No edge may reach past the next cell.
      const double most = std::min(extent[a] / (1.001 * edges.most[a]), static_cast<double>(kGridCells));
      const double count = std::min(std::ceil(extent[a] / width), std::floor(most));
      cells_[a] = count >= 1.0 ? static_cast<std::int32_t>(count) : 1;
      step_[a] = extent[a] > 0.0 ? extent[a] / cells_[a] : 1.0;
      cells = std::min(cells, kGridCells + 1) * static_cast<std::size_t>(cells_[a]);
    }
  }
}

void CoarseGrid::sort_nodes(std::span<const Member> members) {
  struct Node {
    std::size_t cell;
    std::int32_t velocity;
    Vec3 at;  ///< in cells, from the cell's first corner
    Place place;
  };
  std::vector<Node> nodes;
  std::vector<std::uint8_t> prescribed;
  for (std::size_t m = 0; m < members.size(); ++m) {
    const BlockSystem& s = members[m].system;
    prescribed.assign(s.place.size(), 0);
    for (const std::int32_t r : s.prescribed) prescribed[r] = 1;
    for (std::size_t r = 0; r < s.place.size(); ++r) {
      if (prescribed[r]) continue;
      Node n;
      for (int a = 0; a < 3; ++a) {
        const double u = (s.place[r][a] - origin_[a]) / step_[a];
        const double cell = u >= 0.0 ? std::min(std::floor(u), cells_[a] - 1.0) : 0.0;
        n.place[a] = static_cast<std::int32_t>(cell);
        n.at[a] = u - cell;
      }
      n.cell = dense_cell(n.place);
      n.velocity = static_cast<std::int32_t>(members[m].first_v + 3 * r);
      nodes.push_back(n);
    }
  }
  const std::size_t cells =
      static_cast<std::size_t>(cells_[0]) * static_cast<std::size_t>(cells_[1]) * static_cast<std::size_t>(cells_[2]);
  std::vector<std::size_t> first(cells + 1, 0);
  for (const Node& n : nodes) ++first[n.cell + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  cell_of_.assign(cells, -1), cell_.clear(), run_.clear();
  for (std::size_t c = 0; c < cells; ++c) {
    if (first[c] == first[c + 1]) continue;
    cell_of_[c] = static_cast<std::int32_t>(cell_.size());
    cell_.push_back({.at = {}, .begin = first[c], .end = first[c + 1], .corner = {}, .sum = {}});
  }
  velocity_.resize(nodes.size()), code_.resize(nodes.size()), cell_at_.resize(nodes.size());
  weight_.resize(8 * nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Node& n = nodes[i];
    const std::size_t k = first[n.cell]++;  // in order of members and rows
    velocity_[k] = n.velocity;
    node_of_[n.velocity] = static_cast<std::int32_t>(k);
    code_[k] = n.place[0] + (cells_[0] + 2) * (n.place[1] + (cells_[1] + 2) * n.place[2]);
    for (std::size_t b = 0; b < 8; ++b) {
      double w = 1.0;
      for (int a = 0; a < 3; ++a) w *= corner_bit(b, a) ? n.at[a] : 1.0 - n.at[a];
      weight_[8 * k + b] = static_cast<float>(w);
    }
    cell_at_[k] = cell_of_[n.cell];
    cell_[cell_at_[k]].at = n.place;
  }
  // Runs of one cell and one member; the velocities of a member follow those of the previous member.
  for (std::size_t c = 0; c < cell_.size(); ++c)
    for (std::size_t k = cell_[c].begin; k < cell_[c].end; ++k) {
      std::size_t m = 0;
      while (m + 1 < members.size() && static_cast<std::size_t>(velocity_[k]) >= members[m + 1].first_v) ++m;
      if (run_.empty() || run_.back().cell != c || run_.back().member != m) run_.push_back({m, c, k, k});
      run_.back().end = k + 1;
    }
}

void CoarseGrid::number_corners() {
  const Place n = {cells_[0] + 1, cells_[1] + 1, cells_[2] + 1};
  const auto at = [&](const Place& p) {
    return static_cast<std::size_t>(p[0]) +
           static_cast<std::size_t>(n[0]) *
               (static_cast<std::size_t>(p[1]) + static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(p[2]));
  };
  const auto corner_of_cell = [](const Place& p, std::size_t b) {
    return Place{p[0] + corner_bit(b, 0), p[1] + corner_bit(b, 1), p[2] + corner_bit(b, 2)};
  };
  corner_of_.assign(at({n[0] - 1, n[1] - 1, n[2] - 1}) + 1, -1);
  for (const Cell& c : cell_)
    for (std::size_t b = 0; b < 8; ++b) corner_of_[at(corner_of_cell(c.at, b))] = 0;
  corner_.clear();
  Place p;
  for (p[2] = 0; p[2] < n[2]; ++p[2])
    for (p[1] = 0; p[1] < n[1]; ++p[1])
      for (p[0] = 0; p[0] < n[0]; ++p[0]) {
        std::int32_t& number = corner_of_[at(p)];
        if (number < 0) continue;
        number = static_cast<std::int32_t>(corner_.size());
        corner_.push_back(p);
      }
  for (Cell& c : cell_)
    for (std::size_t b = 0; b < 8; ++b) c.corner[b] = corner_of_[at(corner_of_cell(c.at, b))];
}

void CoarseGrid::factor(const ContactRows& rows) {
  sum_ = own_, used_ = own_used_;
  sum_contacts(rows);
  std::swap(first_, first_before_), std::swap(column_, column_before_);
  first_.assign(1, 0), column_.clear(), value_.clear();
  const auto corner_at = [&](const Place& p, std::size_t ahead) {
    const std::size_t code = ahead + 62;
    const std::int32_t x = p[0] + static_cast<std::int32_t>(code % 5) - 2,
                       y = p[1] + static_cast<std::int32_t>(code / 5 % 5) - 2,
                       z = p[2] + static_cast<std::int32_t>(code / 25) - 2;
    return corner_of_[static_cast<std::size_t>(x) +
                      static_cast<std::size_t>(cells_[0] + 1) *
                          (static_cast<std::size_t>(y) +
                           static_cast<std::size_t>(cells_[1] + 1) * static_cast<std::size_t>(z))];
  };
  for (std::size_t I = 0; I < corner_.size(); ++I) {
    for (std::size_t k = 0; k < kAhead; ++k)
      if (used_[kAhead * I + k]) {
        column_.push_back(corner_at(corner_[I], k));
        value_.push_back(sum_[kAhead * I + k]);
      }
    first_.push_back(static_cast<std::int32_t>(column_.size()));
  }
  if (first_ != first_before_ || column_ != column_before_) factor_.analyze(first_, column_);
  factor_.factor(value_);
}

void CoarseGrid::add(std::span<const double> r, std::span<double> z) {
  constexpr std::size_t kGrain = 4;
  parallel_for(
      cell_.size(),
      [&](std::size_t c) {
        Cell& cell = cell_[c];
        coarse_grid_lanes::restrict_to(weight_.data() + 8 * cell.begin, velocity_.data() + cell.begin,
                                       cell.end - cell.begin, r.data(), cell.sum.data());
      },
      kGrain);
  x_.assign(3 * corner_.size(), 0.0f);
  for (const Cell& cell : cell_)
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < 8; ++b) x_[3 * static_cast<std::size_t>(cell.corner[b]) + a] += cell.sum[8 * a + b];
  factor_.solve(x_);
  parallel_for(
      cell_.size(),
      [&](std::size_t c) {
        const Cell& cell = cell_[c];
        float x[24];
        for (std::size_t a = 0; a < 3; ++a)
          for (std::size_t b = 0; b < 8; ++b) x[8 * a + b] = x_[3 * static_cast<std::size_t>(cell.corner[b]) + a];
        coarse_grid_lanes::prolong(weight_.data() + 8 * cell.begin, velocity_.data() + cell.begin,
                                   cell.end - cell.begin, x, z.data());
      },
      kGrain);
}

Eigen::MatrixXd CoarseGrid::dense() const {
  const auto n = static_cast<Eigen::Index>(3 * corner_.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t I = 0; I < corner_.size(); ++I)
    for (std::int32_t k = first_[I]; k < first_[I + 1]; ++k) {
      const auto i = static_cast<Eigen::Index>(3 * I), j = static_cast<Eigen::Index>(3 * column_[k]);
      A.block<3, 3>(i, j) = value_[k].cast<double>();
      A.block<3, 3>(j, i) = A.block<3, 3>(i, j).transpose().eval();
    }
  return A;
}

Eigen::VectorXd CoarseGrid::weights(std::size_t velocity) const {
  Eigen::VectorXd w = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(corner_.size()));
  const std::int32_t node = node_of_[velocity];
  if (node < 0) return w;
  for (const Cell& c : cell_)
    if (static_cast<std::size_t>(node) >= c.begin && static_cast<std::size_t>(node) < c.end)
      for (std::size_t b = 0; b < 8; ++b) w[c.corner[b]] += weight_[8 * static_cast<std::size_t>(node) + b];
  return w;
}

}  // namespace brim
