#include "brim/world/fluid_drag.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/interface_of.h"

namespace brim {

namespace {

/// [cells] width up to which a solid's drag is added, and from which on the flow around it is resolved.
constexpr double kUnresolved = 1.2, kResolved = 2.5;
/// [cells] extent up to which the drag acts at the middle of a solid of known shape.
constexpr double kSingle = 1.5;
/// [cells] reach of the mean W along each axis.
constexpr double kReach = 2.0;
/// Drag coefficient of balls at high Reynolds numbers.
constexpr double kNewton = 0.44;

/// The drag of grains among others is 1/ε^1.65 of that of one alone, ε the share left to the fluid (Wen and Yu 1966).
constexpr double kCrowded = 1.65;

/// γ, [1/s]: force over velocity and mass of displaced fluid. @param u [m/s]  @param t thickness, [m]  @param nu [m²/s]
double drag_rate(bool lines, double u, double t, double nu) {
  if (lines) {
    // C_d = 1 + 10 Re^(−2/3) on A/V = 4/(π t)
    const double viscous = nu > 0.0 ? 10.0 * std::cbrt(u * nu * nu / (t * t)) : 0.0;
    return 2.0 / (std::numbers::pi * t) * (u + viscous);
  }
  // C_d = 24/Re (1 + 0.15 Re^0.687), or Newton's, on A/V = 3/(2 t)
  const double viscous = nu > 0.0 ? 18.0 * nu / (t * t) * (1.0 + 0.15 * std::pow(u * t / nu, 0.687)) : 0.0;
  return std::max(viscous, 0.75 * kNewton * u / t);
}

/// Matter of one source in one cell.
struct Piece {
  std::int32_t cell, source;
  double volume;
  Vec3 moment;
};

/// @param whole  a source is one piece
std::vector<Piece> find_pieces(const FlowsAround& flow, std::span<const Eighth> eighths, bool whole) {
  const MacGrid& g = flow.flow_grid();
  const Vec3i n = 2 * g.n;
  const double volume = std::pow(0.5 * g.dx, 3);
  std::vector<Piece> pieces;
  for (const Eighth& e : eighths) {
    const Vec3i at(e.place % n.x(), e.place / n.x() % n.y(), e.place / (n.x() * n.y()));
    const int cell = g.cell(at / 2);
    if (!flow.is_wet(cell)) continue;
    const Vec3 x = g.origin + 0.5 * g.dx * (at.cast<double>() + Vec3::Constant(0.5) + e.off.cast<double>());
    pieces.push_back({whole ? 0 : cell, e.source, volume * e.share, volume * e.share * x});
  }
  std::ranges::stable_sort(
      pieces, [](const Piece& a, const Piece& b) { return a.cell != b.cell ? a.cell < b.cell : a.source < b.source; });
  std::size_t count = 0;
  for (const Piece& p : pieces) {
    if (count > 0 && pieces[count - 1].cell == p.cell && pieces[count - 1].source == p.source)
      pieces[count - 1].volume += p.volume, pieces[count - 1].moment += p.moment;
    else
      pieces[count++] = p;
  }
  pieces.resize(count);
  return pieces;
}

}  // namespace

void FluidDrag::add(const FlowsAround& flow, int fluid, const WorldPart& solid, std::int32_t part,
                    std::span<const Eighth> eighths) {
  const double dx = flow.flow_grid().dx;
  const double width = solid.info.lines ? solid.info.thickness : std::max(solid.info.thickness, solid.info.width);
  if (!(width < kResolved * dx)) return;
  const auto* balls = interface_of<SpinningBalls>(*solid.body);
  Pair p;
  p.fluid = fluid, p.body = solid.body_index, p.part = part;
  p.density = flow.flow_density(), p.viscosity = flow.flow_viscosity() / p.density;
  p.thickness = solid.info.thickness, p.lines = solid.info.lines;
  p.grains = balls != nullptr;
  p.share = std::clamp((kResolved - width / dx) / (kResolved - kUnresolved), 0.0, 1.0);
  std::vector<std::int32_t> sources;
  const PosedShape* shape = solid_of(*solid.body, solid.index);
  const bool single = shape != nullptr && shape->shape().bounds().extent().maxCoeff() < kSingle * dx;
  for (const Piece& piece : find_pieces(flow, eighths, balls != nullptr || single)) {
    // A place that the grid tells would lie a little off the middle: drag there would spin the solid instead.
    p.at.push_back(balls != nullptr ? balls->ball_center(piece.source)
                   : single
                       ? Vec3(shape->pose().rotation * shape->shape().bounds().center() + shape->pose().translation)
                       : Vec3(piece.moment / piece.volume));
    p.volume.push_back(piece.volume);
    sources.push_back(piece.source);
  }
  if (p.at.empty()) return;
  find_faces(flow, p);
  solid.body->make_map(solid.index, p.at, sources, p.map);
  pairs_.push_back(std::move(p));
}

void FluidDrag::find_faces(const FlowsAround& flow, Pair& p) {
  const MacGrid& g = flow.flow_grid();
  p.first.assign(1, 0);
  for (const Vec3& x : p.at) {
    p.open.push_back(1.0);
    for (int a = 0; a < 3; ++a) {
      const Vec3 s = (x - g.origin) / g.dx - g.face_offset(a);
      const Vec3i low = (s.array() - kReach).ceil().cast<int>().max(0);
      const Vec3i high = (s.array() + kReach).floor().cast<int>().min(g.face_count(a).array() - 1);
      const auto start = static_cast<std::ptrdiff_t>(p.weight.size());
      double sum = 0.0, open = 0.0;
      for (int k = low.z(); k <= high.z(); ++k)
        for (int j = low.y(); j <= high.y(); ++j)
          for (int i = low.x(); i <= high.x(); ++i) {
            const int face = g.face(a, i, j, k);
            const Vec3 way = (Vec3(i, j, k) - s).cwiseAbs() / kReach;
            const double w = flow.flowing_share(face) * (Vec3::Ones() - way).prod();
            if (!(w > 0.0)) continue;
            p.face.push_back(face), p.weight.push_back(w), sum += w, open += w * flow.open_share(face);
          }
      for (auto w = p.weight.begin() + start; w != p.weight.end(); ++w) *w /= sum;
      p.first.push_back(static_cast<std::int32_t>(p.face.size()));
      if (sum > 0.0) p.open.back() = std::min(p.open.back(), open / sum);
    }
  }
}

void FluidDrag::find_slip(const Pair& p, std::span<const double> v) {
  slip_.resize(p.at.size());
  p.map->apply(v.subspan(first_v_[p.body], first_v_[p.body + 1] - first_v_[p.body]), slip_);
  const double* fluid = v.data() + first_v_[p.fluid];
  for (std::size_t i = 0; i < slip_.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int32_t begin = p.first[3 * i + a], end = p.first[3 * i + a + 1];
      double& slip = slip_[i][static_cast<Eigen::Index>(a)];
      if (begin == end) slip = 0.0;
      for (std::int32_t f = begin; f < end; ++f) slip -= p.weight[f] * fluid[p.face[f]];
    }
}

void FluidDrag::begin(std::span<const double> v, std::span<const std::size_t> first_v) {
  first_v_.assign(first_v.begin(), first_v.end());
  for (Pair& p : pairs_) {
    find_slip(p, v);
    p.k.resize(p.at.size());
    for (std::size_t i = 0; i < p.k.size(); ++i) {
      const double crowded = p.grains ? std::pow(p.open[i], -kCrowded) : 1.0;
      const double rate = drag_rate(p.lines, slip_[i].norm(), p.thickness, p.viscosity);
      p.k[i] = p.share * p.density * p.volume[i] * crowded * rate;
    }
  }
}

void FluidDrag::add(double factor, std::span<const double> x, std::span<double> y) {
  for (Pair& p : pairs_) {
    find_slip(p, x);
    double* fluid = y.data() + first_v_[p.fluid];
    for (std::size_t i = 0; i < slip_.size(); ++i) {
      slip_[i] *= factor * p.k[i];
      for (std::size_t a = 0; a < 3; ++a)
        for (std::int32_t f = p.first[3 * i + a]; f < p.first[3 * i + a + 1]; ++f)
          fluid[p.face[f]] -= p.weight[f] * slip_[i][static_cast<Eigen::Index>(a)];
    }
    p.map->apply_transpose(slip_, y.subspan(first_v_[p.body], first_v_[p.body + 1] - first_v_[p.body]));
  }
}

}  // namespace brim
