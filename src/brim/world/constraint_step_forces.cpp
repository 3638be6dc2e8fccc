// Motion and forces at the rows' points in ConstraintStep: relative velocities at the start, impulses recalled from the
// last step, forces on the bodies.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "brim/core/parallel.h"
#include "brim/response/even_loads.h"
#include "brim/world/constraint_step.h"

namespace brim {

namespace {

/// Cosine of normals that count as parallel; share of its limit from which on friction counts as that of sliding.
constexpr double kParallel = 0.9999, kSlides = 0.999;
/// Share of their differences that the loads of a pair with a link lose before each solve, which restores what the
/// motion needs.
constexpr double kEvened = 0.1;

}  // namespace

template <class F>
void ConstraintStep::for_arms(const F& f) const {
  const ContactSet& points = rows_.points();
  parallel_for(
      points.pairs.size(),
      [&](std::size_t p) {
        const ContactPair& pair = points.pairs[p];
        if (pair.begin == pair.end) return;
        const Vec3 a = frame_of(pair.part_a)->rigid_frame().center, b = frame_of(pair.part_b)->rigid_frame().center;
        for (std::size_t c = pair.begin; c < pair.end; ++c)
          f(pair, c, Vec3(points.point[c] - ways_[p].a - a), Vec3(points.point[c] - ways_[p].b - b));
      },
      64);
}

template <class F>
void ConstraintStep::for_grips(const F& f) const {
  const ContactSet& points = rows_.points();
  for (const ContactPair& pair : points.pairs) {
    for (std::size_t c = pair.begin; c < pair.end; ++c)
      if (const Vec3 way = rows_.grips()[c] - points.point[c]; way != Vec3::Zero()) f(pair, c, way);
  }
}

Vec3 ConstraintStep::velocity_at(std::int32_t part, const Vec3& arm, std::span<const double> v) const {
  const double* u = v.data() + first_v_[static_cast<std::size_t>(parts_[part].body_index)];
  return Vec3(u[0], u[1], u[2]) + Vec3(u[3], u[4], u[5]).cross(arm);
}

void ConstraintStep::find_start(std::span<const double> v) {
  const std::size_t n = rows_.points().size(), grips = grip_of_.size();
  start_.resize(n);
  if (mapped_) {
    std::vector<Vec3> a(n), b(n), grip_a(grips), grip_b(grips);
    maps_.velocities(v, a, b);
    for (std::size_t c = 0; c < n; ++c) start_[c] = a[c] - b[c];
    grip_maps_.velocities(v, grip_a, grip_b);
    for (std::size_t i = 0; i < grips; ++i) {
      const std::size_t c = grip_of_[i];
      const Vec3 u = grip_a[i] - grip_b[i], &normal = rows_.normals()[c];
      start_[c] = u + normal * normal.dot(start_[c] - u);
    }
  } else {
    for_arms([&](const ContactPair& pair, std::size_t c, const Vec3& a, const Vec3& b) {
      start_[c] = velocity_at(pair.part_a, a, v) - velocity_at(pair.part_b, b, v);
    });
    const auto spin = [&](std::int32_t part) {
      return Eigen::Map<const Vec3>(v.data() + first_v_[static_cast<std::size_t>(parts_[part].body_index)] + 3);
    };
    for_grips([&](const ContactPair& pair, std::size_t c, const Vec3& way) {
      const Vec3 more = (spin(pair.part_a) - spin(pair.part_b)).cross(way), &normal = rows_.normals()[c];
      start_[c] += more - normal * normal.dot(more);
    });
  }
  for (std::size_t c = 0; c < n; ++c) offset_[c] = frame_[c] * start_[c];
  turning_.begin(parts_, rows_.points(), v, first_v_, settings_.rows.dt);
  if (!turning_.any()) return;
  parallel_for(
      rows_.points().pairs.size(),
      [&](std::size_t p) {
        const ContactPair& pair = rows_.points().pairs[p];
        for (std::size_t c = pair.begin; c < pair.end; ++c)
          offset_[c] += frame_[c] * turning_.slip(pair, rows_.grips()[c], rows_.normals()[c], start_[c],
                                                  rows_.bends()[c].a + rows_.bends()[c].b);
      },
      64);
}

void ConstraintStep::add_mapped_forces(std::span<const Vec3> force, std::span<double> Q) const {
  std::vector<Vec3> at_point(force.begin(), force.end()), at_grip(grip_of_.size());
  for (std::size_t i = 0; i < grip_of_.size(); ++i) {
    const std::size_t c = grip_of_[i];
    const Vec3& normal = rows_.normals()[c];
    at_point[c] = normal * normal.dot(force[c]);
    at_grip[i] = force[c] - at_point[c];
  }
  maps_.add_forces(at_point, Q);
  grip_maps_.add_forces(at_grip, Q);
}

void ConstraintStep::add_forces(std::span<const Vec3> force, std::span<double> Q) const {
  if (mapped_) return add_mapped_forces(force, Q);
  for_grips([&](const ContactPair& pair, std::size_t c, const Vec3& way) {
    const Vec3 torque = way.cross(force[c]);
    // Friction only: tangential motion has no torque about the tangents, only about the normal.
    const Vec3 turn = rows_.normals()[c] * rows_.normals()[c].dot(torque);
    const auto add = [&](std::int32_t part, double sign) {
      if (is_fixed(parts_[part])) return;
      Eigen::Map<Vec3>(Q.data() + first_v_[static_cast<std::size_t>(parts_[part].body_index)] + 3) += sign * turn;
    };
    add(pair.part_a, 1.0);
    add(pair.part_b, -1.0);
  });
  const ContactSet& points = rows_.points();
  for (std::size_t p = 0; p < points.pairs.size(); ++p) {
    const ContactPair& pair = points.pairs[p];
    if (pair.begin == pair.end) continue;
    const auto add = [&](std::int32_t part, const Vec3& way, double sign) {
      if (is_fixed(parts_[part])) return;
      const Vec3 center = frame_of(part)->rigid_frame().center + way;
      Eigen::Map<Eigen::Matrix<double, 6, 1>> q(Q.data() + first_v_[static_cast<std::size_t>(parts_[part].body_index)]);
      for (std::size_t c = pair.begin; c < pair.end; ++c) {
        q.head<3>() += sign * force[c];
        q.tail<3>() += sign * (points.point[c] - center).cross(force[c]);
      }
    };
    add(pair.part_a, ways_[p].a, 1.0);
    add(pair.part_b, ways_[p].b, -1.0);
  }
}

void ConstraintStep::even_out() {
  const ContactSet& points = rows_.points();
  parallel_for(
      points.pairs.size(),
      [&](std::size_t p) {
        const ContactPair& pair = points.pairs[p];
        const std::size_t n = pair.end - pair.begin;
        // What joints hold may bear any torque, and with it any place of the load.
        const bool held = !rigid(pair) && parts_[pair.part_a].solid && parts_[pair.part_b].solid;
        if (held ? n < 2 : n < 4 || !recall_.shared(p) || !rigid(pair)) return;
        const Vec3 normal = rows_.normals()[pair.begin];
        // Points without a load may not touch.
        std::vector<std::size_t> bears;
        std::vector<double> load;
        std::vector<Vec3> at;
        for (std::size_t c = pair.begin; c < pair.end; ++c) {
          if (rows_.normals()[c].dot(normal) < kParallel) return;
          const double l = force_on_a_[c].dot(normal);
          if (l > 0.0) bears.push_back(c), load.push_back(l), at.push_back(points.point[c]);
        }
        const std::vector<double> before = load;
        if (held) {
          const double mean = std::accumulate(load.begin(), load.end(), 0.0) / static_cast<double>(load.size());
          for (double& l : load) l += kEvened * (mean - l);
        } else if (!even_loads(at, normal, load)) {
          return;
        }
        // What slides has the friction of its new load, what sticks keeps it.
        for (std::size_t i = 0; i < bears.size(); ++i) {
          Vec3& f = force_on_a_[bears[i]];
          Vec3 along = f - normal * normal.dot(f);
          if (along.norm() > kSlides * rows_.friction()[bears[i]] * before[i]) along *= load[i] / before[i];
          f = load[i] * normal + along;
        }
      },
      64);
}

void ConstraintStep::recall(std::span<const double> memory) {
  const std::size_t n = rows_.points().size();
  force_on_a_.resize(n);
  recall_.recall(memory, rows_.points(), force_on_a_);
  even_out();
  for (std::size_t c = 0; c < n; ++c) {
    Vec3 l = settings_.rows.dt * (frame_[c] * force_on_a_[c]);
    l.x() = std::max(0.0, l.x());
    const double most = rows_.friction()[c] * l.x(), length = l.tail<2>().norm();
    if (length > most) l.tail<2>() *= most / length;
    lambda_[c] = l;
  }
}

bool ConstraintStep::center_friction(std::span<const Vec3> lambda, std::span<double> change, std::span<double> added) {
  const ContactSet& points = rows_.points();
  for (std::size_t c = 0; c < points.size(); ++c) force_on_a_[c] = frame_[c].transpose() * lambda[c];
  std::vector<Vec3> way, start(start_.begin(), start_.end());
  // Only of what slides on fixed parts alone: among bodies that strike each other sweeps do not converge again.
  std::vector<std::uint8_t> movable, among(bodies_.size(), 0);
  for (const ContactPair& pair : points.pairs)
    if (pair.begin < pair.end && !is_fixed(parts_[pair.part_a]) && !is_fixed(parts_[pair.part_b]))
      among[parts_[pair.part_a].body_index] = among[parts_[pair.part_b].body_index] = 1;
  for (const ContactPair& pair : points.pairs)
    movable.push_back(pair.begin < pair.end && rigid(pair) && among[moving_body(pair)] == 0);
  if (!rows_.center_friction(force_on_a_, movable, way)) return false;
  const std::span<const Vec3> grips = rows_.grips();
  for (const ContactPair& pair : points.pairs)
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      if (way[c] == Vec3::Zero()) continue;
      sweep_.move_friction(c, way[c], lambda[c], change);
      apart_[c] = 1;
      // The spin of the face about its normal, from the row farthest away, changes the slip there.
      const Vec3& n = rows_.normals()[c];
      Vec3 arm = Vec3::Zero(), turn = Vec3::Zero();
      for (std::size_t i = pair.begin; i < pair.end; ++i) {
        const Vec3 d = grips[i] - way[i] - grips[c] + way[c];
        if (way[i] != Vec3::Zero() && rows_.normals()[i].dot(n) > kParallel && d.norm() > arm.norm())
          arm = d, turn = start[i] - start[c];
      }
      const double spin = arm == Vec3::Zero() ? 0.0 : n.dot(arm.cross(turn)) / arm.squaredNorm();
      start_[c] += spin * n.cross(way[c]);
      offset_[c] += frame_[c] * (spin * n.cross(way[c]));
      if (added.empty()) continue;
      const Vec3 torque = way[c].cross(frame_[c].transpose() * guess_[c]);
      const auto add = [&](std::int32_t part, double sign) {
        if (is_fixed(parts_[part])) return;
        Eigen::Map<Vec3>(added.data() + first_v_[static_cast<std::size_t>(parts_[part].body_index)] + 3) +=
            sign * n * n.dot(torque);
      };
      add(pair.part_a, 1.0);
      add(pair.part_b, -1.0);
    }
  if (mapped_) build_maps();
  return true;
}

}  // namespace brim
