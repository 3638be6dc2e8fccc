#include "brim/body/articulated/articulated_body.h"

#include <algorithm>
#include <functional>

#include "brim/core/error.h"

namespace brim {

namespace {

/// Halvings of the way back from a limit, after which a joint waits for a better step.
constexpr int kHalvings = 5;

/// Initial coordinates and velocities of one joint.
void start_of(const JointModel& j, double* q, double* v) {
  const auto write = [](const Quat& any, double* to) {
    const Quat r = any.normalized();
    to[0] = r.w(), to[1] = r.x(), to[2] = r.y(), to[3] = r.z();
  };
  const auto write_vector = [](const Vec3& x, double* to) { std::copy(x.data(), x.data() + 3, to); };
  switch (j.kind) {
    case JointKind::Fixed:
      break;
    case JointKind::Revolute:
    case JointKind::Prismatic:
      q[0] = j.start, v[0] = j.start_velocity;
      break;
    case JointKind::Ball:
      write(j.start_rotation, q);
      write_vector(j.angular_velocity, v);
      break;
    case JointKind::Free:
      write_vector(j.position, q);
      write(j.rotation, q + 3);
      write_vector(j.velocity, v);
      write_vector(j.angular_velocity, v + 3);
      break;
  }
}

}  // namespace

ArticulatedBody::ArticulatedBody(ArticulatedModel model)
    : tree_(model), joints_(model), stops_(model), self_collision_(model.self_collision) {
  start_q_.resize(tree_.q_size()), start_v_.resize(tree_.v_size());
  for (std::size_t i = 0; i < tree_.size(); ++i)
    start_of(model.links[i].joint, start_q_.data() + tree_.links()[i].q0, start_v_.data() + tree_.links()[i].v0);
  none_.assign(tree_.size(), Mat3::Zero());
  contact_->inertia.assign(tree_.size(), Mat6::Zero());
  tree_.place(start_q_, pose_);
  if (!free_inverse_.factor(tree_, pose_, none_))
    throw InputError(
        "articulated body: a joint moves nothing that has mass or inertia; give its links mass, or the joint an "
        "armature");
  name_all(model);
  group_links(model);
  make_parts(model);
  update(0.0, start_q_, start_v_);
}

void ArticulatedBody::name_all(const ArticulatedModel& model) {
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const LinkModel& l = model.links[i];
    link_names_.push_back(l.name.empty() ? std::to_string(i) : l.name);
    joint_names_.push_back(l.joint.name.empty() ? link_names_.back() : l.joint.name);
    const JointDrive& d = l.joint.drive;
    const bool slides_or_turns = l.joint.kind == JointKind::Revolute || l.joint.kind == JointKind::Prismatic;
    if (!slides_or_turns || !(d.stiffness > 0.0 || d.damping > 0.0)) continue;
    drive_names_.push_back(joint_names_.back());
    drives_.push_back({static_cast<int>(i), d});
  }
}

void ArticulatedBody::aim_drive(std::size_t drive, const std::optional<DriveAim>& aim) {
  const Drive& d = drives_.at(drive);
  JointDrive& now = joints_.drive(static_cast<std::size_t>(d.link));
  if (!aim) {
    now = d.given;
    return;
  }
  now.keys.clear();
  now.target = aim->position, now.target_velocity = aim->velocity;
}

double ArticulatedBody::drive_effort(std::size_t drive, double time, std::span<const double> q,
                                     std::span<const double> v) const {
  const int link = drives_.at(drive).link;
  const Tree::Link& l = tree_.links()[link];
  return joints_.drive_effort(static_cast<std::size_t>(link), time, q[l.q0], v[l.v0]);
}

void ArticulatedBody::group_links(const ArticulatedModel& model) {
  const int world = static_cast<int>(model.links.size());
  const auto of = [&](int link) { return link < 0 ? world : group_[link]; };
  for (int i = 0; i < world; ++i) {
    const LinkModel& l = model.links[i];
    if (l.joint.kind == JointKind::Fixed) {
      group_.push_back(of(l.parent));
      continue;
    }
    group_.push_back(i);
    apart_.push_back(std::minmax(i, of(l.parent)));
  }
  for (const auto& [a, b] : model.no_contact) apart_.push_back(std::minmax(of(a), of(b)));
  std::sort(apart_.begin(), apart_.end());
}

void ArticulatedBody::make_parts(ArticulatedModel& model) {
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < model.links.size(); ++i)
    for (LinkShape& s : model.links[i].shapes) {
      Part p{PosedShape(std::move(s.shape), std::move(s.surface)), static_cast<int>(i), s.pose, s.part, Vec3::Zero()};
      const Vec3 middle = p.solid.shape().bounds().center();
      p.middle = p.local.rotation * middle + p.local.translation;
      p.reach = p.solid.reach(middle);
      p.first_vertex = display_.vertices;
      const auto first = static_cast<std::int32_t>(display_.vertices);
      for (const Triangle& t : p.solid.surface().triangles)
        triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
      display_.vertices += p.solid.surface().vertices.size();
      parts_.push_back(std::move(p));
    }
  display_.triangles = std::move(triangles);
}

void ArticulatedBody::initial_state(std::span<double> q, std::span<double> v) const {
  std::copy(start_q_.begin(), start_q_.end(), q.begin());
  std::copy(start_v_.begin(), start_v_.end(), v.begin());
}

void ArticulatedBody::update(double time, std::span<const double> q, std::span<const double> v) {
  time_ = time;
  q_.assign(q.begin(), q.end());
  v_.assign(v.begin(), v.end());
  tree_.place(q, pose_);
  for (Part& p : parts_) {
    const TreePose::Link& l = pose_.link[p.link];
    p.solid.place({l.rotation * p.local.rotation, l.rotation * p.local.translation + l.origin});
  }
  free_inverse_.factor(tree_, pose_, none_);
  joints_.update(tree_, time_, 0.0, q_, v_, free_inverse_, stops_);
}

void ArticulatedBody::begin_solve(double dt) {
  dt_ = dt;
  stops_.choose(dt, free_inverse_);
  joints_.update(tree_, time_ + dt, dt, q_, v_, free_inverse_, stops_);
}

void ArticulatedBody::finish_step(double, double dt, std::span<double> q, std::span<double> v) {
  // What the step moves besides the velocities: out of overlap, or along the broken way of a bounce.
  std::vector<double> straight = q_, way;
  tree_.move(dt, v, straight);
  if (!std::equal(q.begin(), q.end(), straight.begin())) {
    way.resize(v.size());
    tree_.way(straight, q, way);
  }
  std::copy(q_.begin(), q_.end(), q.begin());
  return_from_limits(dt, q, v);
  if (!way.empty()) flow_.shift(tree_, way, q, v);
  flow_.run(tree_, dt, q, v, stops_);
}

void ArticulatedBody::return_from_limits(double dt, std::span<double> q, std::span<double> v) {
  std::vector<Mat3> answer(tree_.size());
  for (std::size_t i = 0; i < answer.size(); ++i) answer[i] = joints_.system(i, dt);
  const std::vector<JointStop> stops = joints_.stops(tree_, v, answer);
  TreeInverse inverse;
  if (stops.empty() || !inverse.factor(tree_, pose_, answer)) return;
  std::vector<double> way(v.begin(), v.end()), to(q.begin(), q.end());
  tree_.move(dt, v, to);
  std::vector<double> allowed = stops_.excess(tree_, q), excess = stops_.excess(tree_, to);
  for (std::size_t i = 0; i < allowed.size(); ++i) allowed[i] = std::max({allowed[i], excess[i], 0.0});
  stops_.hold(tree_, pose_, inverse, answer, stops, v);
  for (std::size_t i = 0; i < v.size(); ++i) way[i] = dt * (way[i] - v[i]);
  // Recoil takes other joints along: of a long way a part, so that none of them leaves its range.
  for (int halving = 0; halving < kHalvings; ++halving) {
    to.assign(q.begin(), q.end());
    tree_.move(1.0, way, to);
    excess = stops_.excess(tree_, to);
    if (std::equal(excess.begin(), excess.end(), allowed.begin(), std::less_equal<>())) {
      flow_.carry(tree_, way, q, v);
      return;
    }
    for (double& x : way) x *= 0.5;
  }
}

void ArticulatedBody::add_forces(const Environment& env, std::span<double> Q) const {
  auto s = scratch_.borrow();
  s->a.resize(tree_.size());
  for (std::size_t i = 0; i < tree_.size(); ++i) {
    const Vec3 weight = tree_.links()[i].mass * env.gravity;
    s->a[i].head<3>() = weight;
    s->a[i].tail<3>() = pose_.link[i].center.cross(weight);
  }
  tree_.add_wrenches(pose_, s->a, Q);
  joints_.add_forces(tree_, Q);
  add_outer_forces(Q);
}

void ArticulatedBody::apply_mass(std::span<const double> x, std::span<double> y) const {
  auto s = scratch_.borrow();
  s->a.resize(tree_.size());
  tree_.add_mass(pose_, x, s->a, y);
}

void ArticulatedBody::apply_stiffness(std::span<const double> x, std::span<double> y) const {
  joints_.subtract_stiffness(tree_, x, y);
}

void ArticulatedBody::apply_damping(std::span<const double> x, std::span<double> y) const {
  joints_.subtract_damping(tree_, x, y);
}

void ArticulatedBody::apply_system(std::span<const double> x, std::span<double> y) const {
  apply_mass(x, y);
  joints_.add_system(tree_, dt_, x, y);
}

void ArticulatedBody::add_system_diagonal(std::size_t first, BlockDiagonal& D) const {
  // Composite inertia: what hangs on a joint as if stiff (Walker and Orin 1982); Sᵀ I S is M's own block.
  auto s = scratch_.borrow();
  s->inertia.resize(tree_.size());
  const auto links = tree_.links();
  for (std::size_t i = 0; i < links.size(); ++i)
    s->inertia[i] = spatial_inertia(links[i].mass, pose_.link[i].center, pose_.link[i].inertia);
  for (std::size_t i = links.size(); i-- > 0;) {
    if (links[i].parent >= 0) s->inertia[links[i].parent] += moved_inertia(s->inertia[i], pose_.link[i].arm);
    if (links[i].dof == 0) continue;
    auto block = D.block(first + links[i].block);
    const int n = links[i].dof;
    const auto S = pose_.link[i].S.leftCols(n);
    block += S.transpose() * s->inertia[i] * S;
    block.diagonal().array() += links[i].armature;
    if (n <= 3) block += joints_.system(i, dt_).topLeftCorner(n, n);
  }
}

void ArticulatedBody::prepare_preconditioner(std::size_t, const BlockDiagonal&) {
  joint_terms_.resize(tree_.size());
  for (std::size_t i = 0; i < tree_.size(); ++i) joint_terms_[i] = joints_.system(i, dt_);
  inverse_good_ = inverse_.factor(tree_, pose_, joint_terms_, contact_->inertia);
  for (Mat6& W : contact_->inertia) W.setZero();  // the maps add to it anew before the next solve
}

void ArticulatedBody::precondition(std::size_t first, const BlockDiagonal& D, std::span<const double> r,
                                   std::span<double> z) const {
  if (!inverse_good_) return Body::precondition(first, D, r, z);
  auto s = scratch_.borrow();
  s->a.resize(tree_.size());
  inverse_.solve(r, s->a, z);
}

bool ArticulatedBody::parts_collide(int p, int q) const {
  const int a = group_[parts_[p].link], b = group_[parts_[q].link];
  return self_collision_ && a != b &&
         !std::binary_search(apart_.begin(), apart_.end(), std::pair<int, int>(std::minmax(a, b)));
}

Vec6 ArticulatedBody::link_twist(int link, std::span<const double> v) const {
  Vec6 V = Vec6::Zero();
  for (int i = link; i >= 0; i = tree_.links()[i].parent) {
    const Vec3 arm = pose_.link[link].origin - pose_.link[i].origin;
    with_dof(tree_.links()[i].dof, [&](auto k) {
      V += moved_twist(pose_.link[i].S.template leftCols<k>() *
                           Eigen::Map<const Eigen::Matrix<double, k, 1>>(v.data() + tree_.links()[i].v0),
                       arm);
    });
  }
  return V;
}

Vec3 ArticulatedBody::mean_velocity(int p, std::span<const double> v) const {
  const int link = parts_[p].link;
  return moved_twist(link_twist(link, v), pose_.link[link].rotation * parts_[p].middle).head<3>();
}

double ArticulatedBody::relative_speed_bound(int p, std::span<const double> v) const {
  return parts_[p].reach * link_twist(parts_[p].link, v).tail<3>().norm();
}

void ArticulatedBody::make_map(int p, std::span<const Vec3> points, std::span<const std::int32_t>,
                               std::unique_ptr<Map>& map) const {
  if (!map) map = std::make_unique<TreeMap>();
  static_cast<TreeMap&>(*map).reset(tree_, pose_, parts_[p].link, points, contact_.get());
}

double ArticulatedBody::potential_energy(const Environment& env) const {
  double e = joints_.energy();
  for (std::size_t i = 0; i < tree_.size(); ++i)
    e -= tree_.links()[i].mass * env.gravity.dot(pose_.link[i].origin + pose_.link[i].center);
  return e;
}

Vec6 ArticulatedBody::momentum(std::span<const double> v) const {
  std::vector<Vec6> V(tree_.size());
  tree_.twists(pose_, v, V);
  return tree_.momentum(pose_, V, Vec3::Zero());
}

bool ArticulatedBody::rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const {
  if (!tree_.floating()) return false;
  std::fill(v.begin(), v.end(), 0.0);
  Eigen::Map<Vec3>(v.data()) = t + w.cross(pose_.link[0].origin);
  Eigen::Map<Vec3>(v.data() + 3) = w;
  return true;
}

void ArticulatedBody::turns(std::span<const double> v, std::span<Turn> part) const {
  // Of the free motion for which finish_step takes the velocities.
  std::vector<Vec6> V(tree_.size()), a(tree_.size()), scratch(tree_.size());
  std::vector<double> bias(v.size(), 0.0), rate(v.size());
  tree_.twists(pose_, v, V);
  tree_.add_bias(pose_, v, V, a, bias);
  for (double& c : bias) c = -c;
  free_inverse_.solve(bias, scratch, rate);
  tree_.twists(pose_, v, V);
  tree_.accelerations(pose_, v, V, rate, a);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const int link = parts_[p].link;
    part[p] = {pose_.link[link].origin, V[link].tail<3>(), a[link].head<3>(), a[link].tail<3>()};
  }
}

void ArticulatedBody::display_positions(std::span<Vec3f> x) const {
  for (const Part& p : parts_) p.solid.display_positions(x.subspan(p.first_vertex, p.solid.surface().vertices.size()));
}

}  // namespace brim
