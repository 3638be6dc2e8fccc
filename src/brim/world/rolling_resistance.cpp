#include "brim/world/rolling_resistance.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "brim/body/rigid_frame.h"
#include "brim/core/interface_of.h"
#include "brim/response/moved_rows.h"

namespace brim {

namespace {

/// One side of a contact: its rotation, and its response to impulses.
struct RollingSide {
  Vec3 lever = Vec3::Zero();  ///< [m] from its centre to the centre of pressure
  Vec3 spin;                  ///< [rad/s] after the sub-step
  double inverse_mass = 0.0;  ///< [1/kg], zero of what is fixed
  Mat3 inverse_inertia;       ///< [1/(kg m²)]
  std::span<double> delta;    ///< its part of the change

  void push(const Vec3& impulse, const Vec3& torque) const {
    const Vec3 turn = inverse_inertia * (lever.cross(impulse) + torque);
    for (Eigen::Index i = 0; i < 3; ++i) {
      delta[static_cast<std::size_t>(i)] += inverse_mass * impulse[i];
      delta[static_cast<std::size_t>(i) + 3] += turn[i];
    }
  }
};

/// Applies the resistance between a and b. @param n  unit normal  @param load  N dt, [N s]  @param friction  impulse on
/// a, [N s]
void resist(const RollingSide& a, const RollingSide& b, const Vec3& n, double load, const Vec3& friction, double mu,
            double reach) {
  const Vec3 w = a.spin - b.spin;
  const Eigen::Matrix<double, 3, 2> along = tangents_of(n);
  const Eigen::Vector2d rolling = along.transpose() * w;
  if (rolling.isZero(0.0)) return;

  // Change of the velocity at x per P, of it per T (and of w per P, its transpose), and of w per T.
  Mat3 by_force = (a.inverse_mass + b.inverse_mass) * Mat3::Identity(), mixed = Mat3::Zero();
  for (const RollingSide* s : {&a, &b}) {
    const Mat3 r = skew(s->lever);
    by_force -= r * s->inverse_inertia * r;
    mixed -= r * s->inverse_inertia;
  }
  const Mat3 by_torque = a.inverse_inertia + b.inverse_inertia;
  const Mat3 held = by_force.ldlt().solve(mixed);  // −P per T
  const auto torque = [&](const Mat3& turn) {
    const Eigen::Matrix2d C = along.transpose() * turn * along;
    Eigen::Vector2d t = C.ldlt().solve(-rolling);
    if (const double size = t.norm(), most = reach * load; size > most) t *= most / size;
    return Vec3(along * t);
  };
  Vec3 T = torque(by_torque - mixed.transpose() * held);
  Vec3 P = -(held * T);
  const Vec3 all = friction + P - n * n.dot(P);
  if (!(all.norm() <= mu * load)) T = torque(by_torque), P.setZero();
  if (!T.allFinite() || !P.allFinite()) return;
  a.push(P, T);
  b.push(-P, -T);
}

}  // namespace

void resist_rolling(std::span<const WorldPart> parts, std::span<const std::size_t> first_v,
                    std::span<const PairReport> pairs, const ContactParameters& laws, const WorldOptions& options,
                    double dt, std::span<const double> v, std::span<double> delta) {
  const auto resists = [](const PairMaterial& m) { return m.rolling_resistance > 0.0; };
  const bool some = std::any_of(parts.begin(), parts.end(),
                                [](const WorldPart& p) { return p.info.material.rolling_resistance > 0.0; }) ||
                    std::any_of(options.pair_materials.begin(), options.pair_materials.end(),
                                [&](const auto& p) { return resists(p.second); });
  if (!some) return;
  const auto side_of = [&](std::int32_t part, const Vec3& x, RollingSide& s) {
    const WorldPart& p = parts[part];
    const auto* rigid = interface_of<RigidFrame>(*p.body);
    if (rigid == nullptr) return false;
    const RigidFrame::Frame frame = rigid->rigid_frame();
    const std::size_t first = first_v[static_cast<std::size_t>(p.body_index)];
    s.delta = delta.subspan(first, 6);
    for (std::size_t i = 0; i < 3; ++i) s.spin[static_cast<Eigen::Index>(i)] = v[first + 3 + i] + delta[first + 3 + i];
    s.lever = x - frame.center;
    s.inverse_mass = is_fixed(p) ? 0.0 : frame.inverse_mass;
    s.inverse_inertia = is_fixed(p) ? Mat3(Mat3::Zero()) : frame.inverse_inertia;
    return true;
  };
  for (const PairReport& pair : pairs) {
    const PairMaterial m = laws.material_of(parts[pair.part_a], parts[pair.part_b], options);
    if (!resists(m)) continue;
    const Vec3 normal = pair.force_on_a - pair.friction_on_a;
    const double load = normal.norm();
    RollingSide a, b;
    if (!(load > 0.0) || !side_of(pair.part_a, pair.center, a) || !side_of(pair.part_b, pair.center, b)) continue;
    resist(a, b, normal / load, load * dt, dt * pair.friction_on_a, m.friction, m.rolling_resistance);
  }
}

}  // namespace brim
