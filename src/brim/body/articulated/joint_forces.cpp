#include "brim/body/articulated/joint_forces.h"

#include <algorithm>
#include <cmath>

#include "brim/math/rotation.h"

namespace brim {

namespace {

constexpr double kFrictionWidth = 0.01;    ///< ε over what friction stops in a step
constexpr double kLimitStiffness = 100.0;  ///< times m / dt²: stops all but a hundredth of a joint's motion in a step
constexpr double kUsualStep = 1.0 / 60.0;  ///< [s] where no step is ahead, and for strains of limits to return in

}  // namespace

std::pair<double, double> target_at(const JointDrive& d, double time) {
  const std::vector<TargetKey>& keys = d.keys;
  if (keys.empty()) return {d.target, d.target_velocity};
  if (time <= keys.front().time) return {keys.front().value, 0.0};
  if (time > keys.back().time) return {keys.back().value, 0.0};
  std::size_t i = 1;
  while (keys[i].time < time) ++i;
  const double slope = (keys[i].value - keys[i - 1].value) / (keys[i].time - keys[i - 1].time);
  return {keys[i - 1].value + slope * (time - keys[i - 1].time), slope};
}

double drive_energy(const JointDrive& d, double miss) {
  if (!(d.stiffness > 0.0)) return 0.0;
  const double pull = d.stiffness * std::abs(miss), most = std::min(pull, d.force_limit);
  return most * (pull - 0.5 * most) / d.stiffness;
}

JointForces::JointForces(const ArticulatedModel& model) {
  for (const LinkModel& l : model.links) {
    const JointModel& j = l.joint;
    joint_.push_back({j.kind == JointKind::Ball, j.lower, j.upper, j.limit_stiffness, j.damping, j.friction, j.drive});
  }
  term_.resize(joint_.size());
}

void JointForces::update(const Tree& tree, double time, double dt, std::span<const double> q, std::span<const double> v,
                         const TreeInverse& mass, const JointStops& stops) {
  energy_ = 0.0;
  acting_.clear();
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Tree::Link& l = tree.links()[i];
    if (l.dof == 0 || l.dof == 6) continue;
    const double* u = v.data() + l.v0;
    term_[i] = term(i, time, dt, mass.pivot(i), joint_displacement(l.dof, q.data() + l.q0),
                    l.dof == 1 ? Vec3(u[0], 0, 0) : Vec3(u[0], u[1], u[2]), stops.hard(i));
  }
}

JointForces::Term JointForces::term(std::size_t link, double time, double dt, double mass, const Vec3& x, const Vec3& u,
                                    bool hard) {
  const Joint& j = joint_[link];
  const bool ball = j.ball;
  Term t;
  const JointDrive& d = j.drive;
  if (d.stiffness > 0.0 || d.damping > 0.0) {
    std::pair<double, double> target = target_at(d, time);
    // Over a step the mean, so that position and velocity agree where the motion has a kink.
    if (!d.keys.empty() && dt > 0.0) target.second = (target.first - target_at(d, time - dt).first) / dt;
    const Vec3 miss = (ball ? Vec3::Zero() : Vec3(target.first, 0, 0)) - x;
    const Vec3 wanted = d.stiffness * miss + d.damping * ((ball ? Vec3::Zero() : Vec3(target.second, 0, 0)) - u);
    // The secant keeps to the limit where the joint is held, and cannot overshoot where it is free.
    const double size = wanted.norm(), s = size > d.force_limit ? d.force_limit / size : 1.0;
    t.force += s * wanted;
    t.K.diagonal().array() += s * d.stiffness;
    t.C.diagonal().array() += s * d.damping;
    energy_ += drive_energy(d, miss.norm());
  }
  double drag = j.damping;
  if (j.friction > 0.0) {
    const double width = kFrictionWidth * j.friction * (dt > 0.0 ? dt : kUsualStep) / mass;
    drag += j.friction / std::max(u.norm(), width);
  }
  t.force -= drag * u;
  t.C.diagonal().array() += drag;
  add_limits(link, dt, mass, x, u, hard, t);
  return t;
}

double JointForces::drive_effort(std::size_t link, double time, double q, double v) const {
  const JointDrive& d = joint_[link].drive;
  const auto [target, rate] = target_at(d, time);
  return std::clamp(d.stiffness * (target - q) + d.damping * (rate - v), -d.force_limit, d.force_limit);
}

void JointForces::add_limits(std::size_t link, double dt, double mass, const Vec3& x, const Vec3& u, bool hard,
                             Term& t) {
  const Joint& j = joint_[link];
  const bool given = j.limit_stiffness > 0.0;
  const double step = dt > 0.0 ? dt : kUsualStep;
  const double k = given ? j.limit_stiffness : kLimitStiffness * mass / (step * step);
  const auto stop = [&](double beyond, double rate, const Vec3& outwards) {
    if (!(beyond + dt * rate > 0.0)) return;
    t.force -= k * beyond * outwards;
    t.K += k * outwards * outwards.transpose();
    // Pushed out within a step, the joint would leave the limit with that speed and fall back, for ever; and a strain
    // of a long step would be pushed out in a short one.
    const double c = beyond > 0.0 ? k * (given ? step : std::max(step, kUsualStep)) : 0.0;
    t.force -= c * rate * outwards;
    t.C += c * outwards * outwards.transpose();
    if (given && beyond > 0.0) energy_ += 0.5 * k * beyond * beyond;
    if (dt > 0.0)
      acting_.push_back({{link, outwards, std::max(-beyond, 0.0) / dt},
                         dt * k * beyond,
                         dt * (dt * k + c),
                         k * beyond + c * rate,
                         k,
                         c,
                         hard});
  };
  if (j.ball) {
    const double angle = x.norm();
    if (angle > 1e-9) stop(angle - j.upper, x.dot(u) / angle, x / angle);
  } else {
    stop(x[0] - j.upper, u[0], Vec3(1, 0, 0));
    stop(j.lower - x[0], -u[0], Vec3(-1, 0, 0));
  }
}

std::pair<double, double> JointForces::impulse_of(const Acting& a, const Tree& tree, std::span<const double> v) {
  const Tree::Link& l = tree.links()[a.stop.link];
  double rate = 0.0;
  for (int k = 0; k < l.dof; ++k) rate += a.stop.outwards[k] * v[l.v0 + k];
  return {-a.push - a.resist * rate, rate};
}

std::vector<JointStop> JointForces::stops(const Tree& tree, std::span<const double> v, std::span<Mat3> T) const {
  std::vector<JointStop> out;
  for (const Acting& a : acting_) {
    if (!a.hard) continue;
    const Vec3& n = a.stop.outwards;
    const auto [impulse, rate] = impulse_of(a, tree, v);
    JointStop stop = a.stop;
    stop.impulse = impulse;
    stop.pulls = stop.impulse > 0.0;
    if (stop.pulls) stop.most = std::min(rate, 0.0);
    out.push_back(stop);
    T[stop.link] -= a.resist * n * n.transpose();
  }
  return out;
}

bool JointForces::release(const Tree& tree, std::span<const double> v) {
  const auto pulls = [&](const Acting& a) { return impulse_of(a, tree, v).first > 0.0; };
  for (const Acting& a : acting_) {
    if (!pulls(a)) continue;
    const Vec3& n = a.stop.outwards;
    Term& t = term_[a.stop.link];
    t.force += a.force * n;
    t.K -= a.k * n * n.transpose();
    t.C -= a.c * n * n.transpose();
  }
  return std::erase_if(acting_, pulls) > 0;
}

void JointForces::add_forces(const Tree& tree, std::span<double> Q) const {
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Tree::Link& l = tree.links()[i];
    for (int k = 0; k < std::min(l.dof, 3) && l.dof < 6; ++k) Q[l.v0 + k] += term_[i].force[k];
  }
}

namespace {

/// y += A x over one joint.
void add(const Tree::Link& l, const Mat3& A, std::span<const double> x, std::span<double> y) {
  if (l.dof == 6) return;
  for (int r = 0; r < l.dof; ++r)
    for (int c = 0; c < l.dof; ++c) y[l.v0 + r] += A(r, c) * x[l.v0 + c];
}

}  // namespace

void JointForces::subtract_stiffness(const Tree& tree, std::span<const double> x, std::span<double> y) const {
  for (std::size_t i = 0; i < tree.size(); ++i) add(tree.links()[i], -term_[i].K, x, y);
}

void JointForces::subtract_damping(const Tree& tree, std::span<const double> x, std::span<double> y) const {
  for (std::size_t i = 0; i < tree.size(); ++i) add(tree.links()[i], -term_[i].C, x, y);
}

void JointForces::add_system(const Tree& tree, double dt, std::span<const double> x, std::span<double> y) const {
  for (std::size_t i = 0; i < tree.size(); ++i) add(tree.links()[i], system(i, dt), x, y);
}

}  // namespace brim
