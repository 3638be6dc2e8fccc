#include "brim/world/fluid_coupling.h"

#include <algorithm>
#include <cmath>

#include "brim/body/distance_bound.h"
#include "brim/body/posed_shape.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/math/block_diagonal.h"
#include "brim/math/ramp.h"

namespace brim {

namespace {

/// Flow that may remain in a cell, over the largest before.
constexpr double kFlowTolerance = 1e-8;
/// The same over the flow through a face.
constexpr double kFlowRounding = 1e-13;
constexpr int kMostIterations = 300;

/// What flows; a fluid that is frozen is met by contact.
const FlowsAround* fluid_of(const WorldPart& p) {
  return p.info.conforming && !p.frozen ? interface_of<FlowsAround>(*p.body) : nullptr;
}

double largest_of_flow(std::span<const double> x) {
  double most = 0.0;
  for (const double xi : x) most = std::max(most, std::abs(xi));
  return most;
}

double dot_cells(std::span<const double> a, std::span<const double> b) {
  return ordered_sum(
      a.size(),
      [&](std::size_t begin, std::size_t end) {
        double s = 0.0;
        for (std::size_t i = begin; i < end; ++i) s += a[i] * b[i];
        return s;
      },
      4096);
}

}  // namespace

bool flows_around(const WorldPart& a, const WorldPart& b) {
  if (a.info.conforming == b.info.conforming) return false;
  const FlowsAround *fa = fluid_of(a), *fb = fluid_of(b);
  return (fa != nullptr && fa->flows_around(b.info)) || (fb != nullptr && fb->flows_around(a.info));
}

std::vector<FluidCoupling::Fluid> FluidCoupling::find_fluids(std::span<const std::unique_ptr<Body>> bodies,
                                                             std::span<const WorldPart> parts) const {
  std::vector<Fluid> fluids;
  for (std::size_t f = 0; f < parts.size(); ++f) {
    if (fluid_of(parts[f]) == nullptr) continue;
    Fluid& fluid = fluids.emplace_back();
    fluid.flow = dynamic_cast<FlowsAround*>(bodies[parts[f].body_index].get());
    fluid.part = static_cast<std::int32_t>(f), fluid.body = parts[f].body_index;
    for (std::size_t s = 0; s < parts.size(); ++s)
      if (flows_around(parts[f], parts[s]) && rules_allow(parts[f], parts[s])) {
        Side& side = fluid.sides.emplace_back();
        side.part = static_cast<std::int32_t>(s), side.body = parts[s].body_index;
      }
  }
  return fluids;
}

void FluidCoupling::find(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
                         std::span<const double> q, std::span<const std::size_t> first_v, std::span<double> v) {
  std::vector<Fluid> fluids = find_fluids(bodies, parts);
  look_.clear();
  for (const Fluid& f : fluids) {
    look_.push_back(f.part);
    for (const Side& s : f.sides) look_.push_back(s.part);
  }
  if (fluids.empty() && found_.empty()) return;
  const bool known = look_ == found_ &&
                     std::ranges::all_of(fluids, [](const Fluid& f) { return f.flow->has_taken_solids(); }) &&
                     std::equal(q.begin(), q.end(), found_q_.begin(), found_q_.end()) &&
                     std::equal(bodies.begin(), bodies.end(), body_.begin(), body_.end(),
                                [](const auto& a, const Body* b) { return a.get() == b; });
  if (known) return;
  found_ = look_, found_q_.assign(q.begin(), q.end());
  first_.assign(first_v.begin(), first_v.end());
  body_.clear();
  for (const auto& b : bodies) body_.push_back(b.get());
  solids_.clear(), rows_ = 0;
  for (Fluid& fluid : fluids) {
    const ProfileScope scope("flows around", *parts[fluid.part].body);
    find_shares(fluid, parts);
    fluid.flow->set_solids(octant_, v.empty() ? v : slice(v, fluid.body));
    if (!fluid.sides.empty()) find_rows(fluid, parts);
    for (const Side& s : fluid.sides) solids_.push_back(s.body), rows_ += s.rows.size();
  }
  std::erase_if(fluids, [](const Fluid& f) { return f.sides.empty(); });
  std::sort(solids_.begin(), solids_.end());
  solids_.erase(std::unique(solids_.begin(), solids_.end()), solids_.end());
  fluids_ = std::move(fluids);
  for (Fluid& f : fluids_) {
    const std::size_t n = f.flow->flow_grid().cells();
    for (auto* x : {&f.pressure, &f.guess, &f.x, &f.r, &f.p, &f.y, &f.z}) x->assign(n, 0.0);
  }
}

void FluidCoupling::sample(const MacGrid& g, const WorldPart& part, const PosedShape* solid, std::vector<Eighth>& out) {
  const double h = 0.5 * g.dx, w = 3.0 * g.dx;
  const Vec3i n = 2 * g.n;
  const Vec3 origin = g.origin / h + Vec3::Constant(0.5);
  const Vec3i first = origin.array().floor().cast<int>();
  const Vec3 t = origin - first.cast<double>();  // of a middle of an eighth, from the node below it
  const int p = part.index;
  const Aabb region = part.body->bounds(p).inflated(g.dx).intersection(g.box().inflated(g.dx));
  tiles_.clear(), out.clear();
  if (!region.empty()) part.body->presence(p, h, w, region, tiles_);
  std::sort(tiles_.begin(), tiles_.end());
  tiles_.erase(std::unique(tiles_.begin(), tiles_.end()), tiles_.end());
  if (tiles_.empty()) return;
  if (blocks_.size() < tiles_.size()) blocks_.resize(tiles_.size());
  const auto blocks = std::span(blocks_).first(tiles_.size());
  for (DensityBlock& b : blocks) b.octants = kAllOctants;
  part.body->rasterize(p, h, w, tiles_, blocks);
  std::vector<std::vector<Eighth>> piece(tiles_.size());
  parallel_for(tiles_.size(), [&](std::size_t k) {
    const DensityBlock& block = blocks[k];
    const Vec3i tile = kTileSize * Vec3i(tiles_[k].x, tiles_[k].y, tiles_[k].z);
    std::array<double, kBlockNodes> distance;
    for (int i = 0; i < kBlockNodes; ++i) {
      const double rho = block.rho[i];
      distance[i] = rho <= 0.0 ? 0.5 * w : rho >= 1.0 ? -0.5 * w : ramp_inverse(rho, w);
    }
    for (int c = 0; c < kTileSize; ++c)
      for (int b = 0; b < kTileSize; ++b)
        for (int a = 0; a < kTileSize; ++a) {
          const Vec3i at = tile + Vec3i(a, b, c) - first;
          if ((at.array() < 0).any() || (at.array() >= n.array()).any()) continue;
          double d = 0.0, fullest = 0.0;
          Vec3 slope = Vec3::Zero();
          std::int32_t source = 0;
          for (int corner = 0; corner < 8; ++corner) {
            const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
            const int node = block_index(a + x + kHalo, b + y + kHalo, c + z + kHalo);
            const double dist = distance[node];
            const double wx = x ? t[0] : 1.0 - t[0], wy = y ? t[1] : 1.0 - t[1], wz = z ? t[2] : 1.0 - t[2];
            d += wx * wy * wz * dist;
            slope +=
                dist / h * Vec3((x ? 1.0 : -1.0) * wy * wz, wx * (y ? 1.0 : -1.0) * wz, wx * wy * (z ? 1.0 : -1.0));
            if (block.rho[node] > fullest) fullest = block.rho[node], source = block.source[node];
          }
          const double length = slope.norm();
          const double width = h * (length > 1e-6 ? slope.lpNorm<1>() / length : 1.0);
          double share = std::clamp(0.5 - d / width, 0.0, 1.0);
          if (solid != nullptr && std::abs(d) < h) {
            // What is known everywhere is asked at the middles of eighths of it: edges are no planes.
            share = 0.0;
            const Vec3 middle = g.origin + h * (at.cast<double>() + Vec3::Constant(0.5));
            for (int corner = 0; corner < 8; ++corner) {
              const Vec3 x = middle + 0.25 * h * Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
              const double there = solid->shape().distance(solid->pose().to_local(x));
              share += 0.125 * std::clamp(0.5 - 2.0 * there / width, 0.0, 1.0);
            }
          }
          if (share > 0.0)
            piece[k].push_back({at.x() + n.x() * (at.y() + n.y() * at.z()), static_cast<float>(share), source});
        }
  });
  for (const auto& found : piece) out.insert(out.end(), found.begin(), found.end());
}

void FluidCoupling::find_shares(Fluid& fluid, std::span<const WorldPart> parts) {
  const MacGrid& g = fluid.flow->flow_grid();
  octant_.clear();
  for (Side& side : fluid.sides) {
    const WorldPart& part = parts[side.part];
    Shares& shares = shares_[{fluid.part, side.part}];
    // What does not move is sampled once.
    const auto* bound = interface_of<DistanceBound>(*part.body);
    const PosedShape* solid = bound != nullptr ? bound->solid(part.index) : nullptr;
    const bool same = solid != nullptr && shares.body == part.body && shares.origin == g.origin &&
                      shares.pose.rotation == solid->pose().rotation &&
                      shares.pose.translation == solid->pose().translation;
    shares.body = part.body, shares.origin = g.origin;
    if (solid != nullptr) shares.pose = solid->pose();
    if (!same) sample(g, part, solid, shares.eighths);
    side.eighths = &shares.eighths;
    if (shares.eighths.empty()) continue;
    if (octant_.empty()) octant_.assign(8 * g.cells(), 0.0f);
    for (const Eighth& e : shares.eighths) octant_[e.place] += e.share;
  }
  std::erase_if(fluid.sides, [](const Side& s) { return s.eighths->empty(); });
}

void FluidCoupling::find_rows(Fluid& fluid, std::span<const WorldPart> parts) {
  const MacGrid& g = fluid.flow->flow_grid();
  const Vec3i n = 2 * g.n;
  std::vector<float> share(g.faces(), 0.0f), best(g.faces(), 0.0f);
  std::vector<std::int32_t> source(g.faces(), 0), touched, sources;
  std::vector<float> all(g.faces(), 0.0f);
  // Calls f(face, share of its cube); solids that overlap each have their part of what there is.
  const auto for_faces = [&](const Eighth& e, const auto& f) {
    const Vec3i at(e.place % n.x(), e.place / n.x() % n.y(), e.place / (n.x() * n.y()));
    const float part = 0.125f * e.share / std::max(1.0f, octant_[e.place]);
    for (int a = 0; a < 3; ++a) {
      Vec3i cell = at / 2;
      // At the box's sides as the fluid continues what it is told (set_solids).
      for (const int side : {0, g.n[a]}) {
        const int layer = side == 0 ? at[a] : n[a] - 1 - at[a];
        if (layer > 1) continue;
        cell[a] = side;
        f(g.face(a, cell), layer == 0 ? 3.0f * part : -part);
      }
      cell[a] = (at[a] + 1) / 2;
      if (cell[a] > 0 && cell[a] < g.n[a]) f(g.face(a, cell), part);
    }
  };
  for (const Side& side : fluid.sides)
    for (const Eighth& e : *side.eighths) for_faces(e, [&](int f, float part) { all[f] += part; });
  std::vector<Side> kept;
  for (Side& side : fluid.sides) {
    touched.clear(), sources.clear();
    for (const Eighth& e : *side.eighths)
      for_faces(e, [&](int f, float part) {
        if (best[f] == 0.0f) touched.push_back(f);
        share[f] += part;
        if (e.share > best[f]) best[f] = e.share, source[f] = e.source;
      });
    std::sort(touched.begin(), touched.end());
    for (const int f : touched) {
      const int a = f % 3, place = f / 3;
      const Vec3i hi(place % (g.n.x() + 1), place / (g.n.x() + 1) % (g.n.y() + 1),
                     place / ((g.n.x() + 1) * (g.n.y() + 1)));
      const int high = g.cell(hi), low = high - g.cell_stride(a);
      const bool wet_low = hi[a] > 0 && fluid.flow->is_wet(low);
      const bool wet_high = hi[a] < g.n[a] && fluid.flow->is_wet(high);
      if ((wet_low || wet_high) && all[f] > 0.0f && share[f] > 0.0f) {
        // All that is not open to the fluid is the solids'.
        const double part = std::min(double{share[f]} / all[f], 1.0) * (1.0 - fluid.flow->open_share(f));
        side.rows.push_back({wet_low ? low : -1, wet_high ? high : -1, a, part * g.dx * g.dx});
        side.points.push_back(g.face_position(a, hi.x(), hi.y(), hi.z()));
        sources.push_back(source[f]);
      }
      share[f] = best[f] = 0.0f;
    }
    if (side.rows.empty()) continue;
    const WorldPart& part = parts[side.part];
    part.body->make_map(part.index, side.points, sources, side.map);
    kept.push_back(std::move(side));
  }
  fluid.sides = std::move(kept);
}

void FluidCoupling::prepare(const BlockDiagonal& diagonal, std::span<const std::size_t> first_block,
                            std::span<const std::uint8_t> held) {
  diagonal_ = &diagonal;
  first_block_.assign(first_block.begin(), first_block.end());
  held_.assign(held.begin(), held.end());
}

void FluidCoupling::add_solid_flow(Fluid& f, std::span<const double> u, std::span<double> out) {
  for (const Side& s : f.sides) {
    at_points_.resize(s.rows.size());
    s.map->apply(slice(u, s.body), at_points_);
    for (std::size_t i = 0; i < s.rows.size(); ++i) {
      const Row& row = s.rows[i];
      const double through = row.area * at_points_[i][row.axis];
      if (row.low >= 0) out[row.low] += through;
      if (row.high >= 0) out[row.high] -= through;
    }
  }
}

void FluidCoupling::push_solids(const Fluid& f, std::span<const double> pressure, std::span<double> impulse) {
  for (const Side& s : f.sides) {
    at_points_.assign(s.rows.size(), Vec3::Zero());
    for (std::size_t i = 0; i < s.rows.size(); ++i) {
      const Row& row = s.rows[i];
      at_points_[i][row.axis] =
          row.area * ((row.low >= 0 ? pressure[row.low] : 0.0) - (row.high >= 0 ? pressure[row.high] : 0.0));
    }
    s.map->apply_transpose(at_points_, slice(impulse, s.body));
  }
}

void FluidCoupling::flow(std::span<const double> u, std::vector<double> Fluid::*out) {
  for (Fluid& f : fluids_) {
    std::vector<double>& to = f.*out;
    std::fill(to.begin(), to.end(), 0.0);
    f.flow->add_flow(slice(u, f.body), to);
    add_solid_flow(f, u, to);
  }
}

void FluidCoupling::push(const std::vector<double> Fluid::*pressure, std::span<double> impulse) {
  for (Fluid& f : fluids_) {
    f.flow->add_push(f.*pressure, slice(impulse, f.body));
    push_solids(f, f.*pressure, impulse);
  }
}

void FluidCoupling::divide(std::span<const double> r, std::span<double> z) {
  for (const Fluid& f : fluids_) f.flow->divide_by_mass(slice(r, f.body), slice(z, f.body));
  divide_solids(r, z);
}

void FluidCoupling::divide_solids(std::span<const double> r, std::span<double> z) {
  for (const int b : solids_) {
    const auto zb = slice(z, b);
    std::fill(zb.begin(), zb.end(), 0.0);
    if (zb.empty() || body_[b]->immobile() || (!held_.empty() && held_[b])) continue;
    const auto rb = slice(r, b);
    own_.assign(rb.begin(), rb.end());
    body_[b]->filter(own_);
    diagonal_->solve_from(first_block_[b], own_, zb);
    body_[b]->filter(zb);
  }
}

void FluidCoupling::add_yield() {
  for (const int b : solids_) {
    const auto to = slice(std::span<double>(impulse_), b);
    std::fill(to.begin(), to.end(), 0.0);
  }
  for (const Fluid& f : fluids_) push_solids(f, f.p, impulse_);
  divide_solids(impulse_, velocity_);
  for (Fluid& f : fluids_) add_solid_flow(f, velocity_, f.y);
}

int FluidCoupling::solve(double tolerance) {
  // The fluids' own part, a Poisson equation, and beside it what the solids yield: each of its few motions costs an
  // iteration where a solid is light.
  double most = 0.0, rz = 0.0;
  for (Fluid& f : fluids_) {
    std::fill(f.x.begin(), f.x.end(), 0.0);
    most = std::max(most, largest_of_flow(f.r));
  }
  impulse_.resize(first_.back()), velocity_.resize(first_.back());
  int iterations = 0;
  while (most > tolerance && iterations < kMostIterations) {
    double next = 0.0;
    for (Fluid& f : fluids_) {
      f.flow->invert_poisson(f.r, f.z);
      next += dot_cells(f.r, f.z);
    }
    if (!(next > 0.0) || !std::isfinite(next)) break;
    const double ratio = iterations > 0 ? next / rz : 0.0;
    rz = next;
    for (Fluid& f : fluids_)
      for (std::size_t c = 0; c < f.p.size(); ++c) f.p[c] = f.z[c] + ratio * f.p[c];
    for (Fluid& f : fluids_) f.flow->apply_poisson(f.p, f.y);
    add_yield();
    double curvature = 0.0;
    for (Fluid& f : fluids_) curvature += dot_cells(f.p, f.y);
    if (!(curvature > 0.0)) break;
    const double step = rz / curvature;
    most = 0.0;
    for (Fluid& f : fluids_) {
      for (std::size_t c = 0; c < f.p.size(); ++c) {
        f.x[c] += step * f.p[c];
        f.r[c] -= step * f.y[c];
      }
      most = std::max(most, largest_of_flow(f.r));
    }
    ++iterations;
  }
  profile_count("pressure iterations among solids", iterations);
  return iterations;
}

void FluidCoupling::start(std::span<const double> v, std::span<double> delta) {
  velocity_.assign(first_.back(), 0.0);
  std::vector<double> sum(v.begin(), v.end());
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += delta[i];
  flow(sum, &Fluid::r);
  double most = 0.0;
  for (Fluid& f : fluids_) {
    for (double& x : f.r) x = -x;
    most = std::max(most, largest_of_flow(f.r));
  }
  solve(kFlowTolerance * most);
  impulse_.assign(first_.back(), 0.0);
  push(&Fluid::x, impulse_);
  divide(impulse_, velocity_);
  for (std::size_t i = 0; i < delta.size(); ++i) delta[i] += velocity_[i];
  for (Fluid& f : fluids_) f.pressure = f.x;
}

void FluidCoupling::resist(std::span<double> r) {
  // From the last on, which hardly changes within a solve, only what is new is computed.
  velocity_.assign(first_.back(), 0.0);
  push(&Fluid::guess, r);
  divide(r, velocity_);
  flow(velocity_, &Fluid::r);
  double most = 0.0;
  for (Fluid& f : fluids_) {
    for (double& x : f.r) x = -x;
    most = std::max(most, largest_of_flow(f.r));
  }
  const double fastest = largest_of_flow(velocity_), area = std::pow(fluids_.front().flow->flow_grid().dx, 2);
  solve(std::max(kFlowTolerance * most, 1e-2 * kFlowRounding * area * fastest));
  push(&Fluid::x, r);
  for (Fluid& f : fluids_)
    for (std::size_t c = 0; c < f.guess.size(); ++c) f.guess[c] += f.x[c];
}

void FluidCoupling::correct(std::span<double> z) {
  flow(z, &Fluid::r);
  for (Fluid& f : fluids_)
    for (double& x : f.r) x = -x;
  double fastest = 0.0;
  for (const Fluid& f : fluids_)
    fastest = std::max(fastest, largest_of_flow(slice(std::span<const double>(z), f.body)));
  const double area = std::pow(fluids_.front().flow->flow_grid().dx, 2);
  velocity_.assign(first_.back(), 0.0);
  if (solve(kFlowTolerance * area * fastest) == 0) return;
  impulse_.assign(first_.back(), 0.0);
  push(&Fluid::x, impulse_);
  divide(impulse_, velocity_);
  for (std::size_t i = 0; i < z.size(); ++i) z[i] += velocity_[i];
}

void FluidCoupling::relieve(std::span<double> r) {
  for (Fluid& f : fluids_) f.guess = f.pressure;
  resist(r);
  for (Fluid& f : fluids_) {
    f.pressure.swap(f.guess);
    std::fill(f.guess.begin(), f.guess.end(), 0.0);
  }
}

void FluidCoupling::finish(std::span<double> r) {
  relieve(r);
  for (Fluid& f : fluids_) f.flow->take_pressure(f.pressure);
}

void FluidCoupling::give_back(std::span<const double> residual, std::span<double> delta) const {
  for (const Fluid& f : fluids_) {
    const Body& body = *body_[f.body];
    const auto left = slice(residual, f.body);
    const auto change = slice(delta, f.body);
    std::vector<double> all(left.size()), impulse(left.size());
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = i % 3 == a ? 1.0 : 0.0;
      body.filter(all);
      std::fill(impulse.begin(), impulse.end(), 0.0);
      body.apply_mass(all, impulse);
      double lost = 0.0, mass = 0.0;
      for (std::size_t i = a; i < all.size(); i += 3) lost += all[i] * left[i], mass += all[i] * impulse[i];
      if (!(mass > 0.0)) continue;
      for (std::size_t i = a; i < all.size(); i += 3) change[i] += lost / mass * all[i];
    }
  }
}

void FluidCoupling::report(double dt, StepReport& report) const {
  for (const Fluid& f : fluids_)
    for (const Side& s : f.sides) {
      PairReport r;
      r.part_a = std::min(f.part, s.part), r.part_b = std::max(f.part, s.part);
      r.contacts = static_cast<std::int32_t>(s.rows.size());
      Vec3 on_solid = Vec3::Zero();
      double load = 0.0;
      for (std::size_t i = 0; i < s.rows.size(); ++i) {
        const Row& row = s.rows[i];
        const double push =
            row.area / dt * ((row.low >= 0 ? f.pressure[row.low] : 0.0) - (row.high >= 0 ? f.pressure[row.high] : 0.0));
        on_solid[row.axis] += push;
        r.center += std::abs(push) * s.points[i];
        load += std::abs(push);
      }
      if (load > 0.0) r.center /= load;
      r.force_on_a = s.part < f.part ? on_solid : Vec3(-on_solid);
      report.pairs.push_back(r);
    }
  std::sort(report.pairs.begin(), report.pairs.end(), [](const PairReport& r, const PairReport& s) {
    return r.part_a != s.part_a ? r.part_a < s.part_a : r.part_b < s.part_b;
  });
}

}  // namespace brim
