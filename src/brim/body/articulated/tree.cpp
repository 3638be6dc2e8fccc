#include "brim/body/articulated/tree.h"

#include "brim/core/error.h"
#include "brim/math/rotation.h"
#include "brim/math/small_symmetric.h"

namespace brim {

namespace {

constexpr int kDof[] = {0, 1, 1, 3, 6};
constexpr int kCoordinates[] = {0, 1, 1, 4, 7};

Quat quaternion(const double* q) { return Quat(q[0], q[1], q[2], q[3]).normalized(); }

void write(const Quat& r, double* q) { q[0] = r.w(), q[1] = r.x(), q[2] = r.y(), q[3] = r.z(); }

/// Derivative of a quaternion whose frame turns at w, axes of the frame it is seen from.
void quaternion_rate(const double* q, const double* w, double* rate) {
  rate[0] = -0.5 * (w[0] * q[1] + w[1] * q[2] + w[2] * q[3]);
  rate[1] = 0.5 * (w[0] * q[0] + w[1] * q[3] - w[2] * q[2]);
  rate[2] = 0.5 * (w[1] * q[0] + w[2] * q[1] - w[0] * q[3]);
  rate[3] = 0.5 * (w[2] * q[0] + w[0] * q[2] - w[1] * q[1]);
}

void check_link(const LinkModel& m, std::size_t i) {
  const auto wrong = [&](const std::string& what) {
    return InputError(fmt::format("articulated body: link {} \"{}\": {}", i, m.name, what));
  };
  if (m.parent < -1 || m.parent >= static_cast<int>(i))
    throw wrong(fmt::format("its parent is {}, but must be an earlier link, or -1 for the world", m.parent));
  if (!(m.mass >= 0.0) || !std::isfinite(m.mass))
    throw wrong(fmt::format("mass is {}, but must be finite and at least 0 [kg]", m.mass));
  if (!m.inertia.allFinite() || !m.center_of_mass.allFinite()) throw wrong("its inertia is not finite");
  if (symmetric_axes(m.inertia).values.minCoeff() < -1e-9 * m.inertia.norm())
    throw wrong("the inertia tensor has a negative eigenvalue");
  const JointModel& j = m.joint;
  const bool one = j.kind == JointKind::Revolute || j.kind == JointKind::Prismatic;
  if (one && !(j.axis.norm() > 0.0)) throw wrong("the joint's axis has length zero");
  if (j.kind == JointKind::Free && m.parent != -1) throw wrong("only a link without a parent can be free");
  for (const double x : {j.damping, j.friction, j.armature, j.limit_stiffness, j.drive.stiffness, j.drive.damping})
    if (!(x >= 0.0) || !std::isfinite(x))
      throw wrong(
          fmt::format("a joint's damping, friction, armature, limit or drive is {}, but must be at least 0", x));
  if (!(j.drive.force_limit > 0.0)) throw wrong("the drive's force limit must be above 0");
  if (one && !(j.lower <= j.upper)) throw wrong(fmt::format("limits {} to {} are out of order", j.lower, j.upper));
  if (j.kind == JointKind::Ball && !(j.upper > 0.0)) throw wrong("a ball joint's limit must be an angle above 0");
  for (std::size_t k = 1; k < j.drive.keys.size(); ++k)
    if (!(j.drive.keys[k].time > j.drive.keys[k - 1].time)) throw wrong("times of the drive's keys must increase");
}

}  // namespace

Tree::Tree(const ArticulatedModel& model) {
  int roots = 0;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const LinkModel& m = model.links[i];
    check_link(m, i);
    Link l;
    l.parent = m.parent;
    l.kind = m.joint.kind;
    l.dof = kDof[static_cast<int>(l.kind)];
    l.q0 = nq_, l.v0 = nv_;
    nq_ += kCoordinates[static_cast<int>(l.kind)], nv_ += l.dof;
    if (l.dof > 0) {
      l.block = static_cast<int>(blocks_.size());
      blocks_.push_back(l.dof);
    }
    const bool free = l.kind == JointKind::Free;  // its coordinates are the world's own
    l.frame_rotation = free ? Mat3::Identity() : m.joint.rotation.normalized().toRotationMatrix();
    l.frame_position = free ? Vec3::Zero() : m.joint.position;
    l.start_frame = {l.frame_rotation, l.frame_position};
    has_free_ = has_free_ || free;
    l.axis = m.joint.axis.normalized();
    l.mass = m.mass, l.com = m.center_of_mass, l.inertia = m.inertia;
    l.armature = free ? 0.0 : m.joint.armature;
    mass_ += m.mass;
    roots += m.parent == -1;
    links_.push_back(l);
  }
  if (nv_ == 0) throw InputError("articulated body: no joint can move; a fixed thing is an obstacle");
  floating_ = roots == 1 && links_[0].kind == JointKind::Free;
}

void Tree::set_base(const Pose& from_start) {
  for (Link& l : links_) {
    if (l.parent != -1) continue;
    l.frame_rotation = from_start.rotation * l.start_frame.rotation;
    l.frame_position = from_start.rotation * l.start_frame.translation + from_start.translation;
  }
}

void Tree::place(std::span<const double> q, TreePose& pose) const {
  pose.link.resize(links_.size());
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& l = links_[i];
    TreePose::Link& p = pose.link[i];
    Mat3 R = l.frame_rotation;  // the joint's frame
    Vec3 d = l.frame_position;  // from the parent's origin
    Vec3 base = Vec3::Zero();
    if (l.parent >= 0) {
      const TreePose::Link& parent = pose.link[l.parent];
      R = parent.rotation * R;
      d = parent.rotation * d;
      base = parent.origin;
    }
    p.rotation = R;
    p.S.setZero();
    const double* c = q.data() + l.q0;
    switch (l.kind) {
      case JointKind::Fixed:
        break;
      case JointKind::Revolute:
        p.S.col(0).tail<3>() = R * l.axis;
        p.rotation = R * Eigen::AngleAxisd(c[0], l.axis).toRotationMatrix();
        break;
      case JointKind::Prismatic:
        p.S.col(0).head<3>() = R * l.axis;
        d += c[0] * (R * l.axis);
        break;
      case JointKind::Ball:
        p.S.bottomLeftCorner<3, 3>() = R;
        p.rotation = R * quaternion(c).toRotationMatrix();
        break;
      case JointKind::Free:
        p.S.setIdentity();
        d = Vec3(c[0], c[1], c[2]);
        p.rotation = quaternion(c + 3).toRotationMatrix();
        break;
    }
    p.arm = d;
    p.origin = base + d;
    p.center = p.rotation * l.com;
    p.inertia = p.rotation * l.inertia * p.rotation.transpose();
  }
}

void Tree::move(double dt, std::span<const double> v, std::span<double> q) const {
  for (const Link& l : links_) {
    double* c = q.data() + l.q0;
    const double* u = v.data() + l.v0;
    if (l.dof == 1) c[0] += dt * u[0];
    if (l.dof == 6) {
      for (int a = 0; a < 3; ++a) c[a] += dt * u[a];
      c += 3, u += 3;
    }
    if (l.dof >= 3) write((rotation_from_vector(dt * Vec3(u[0], u[1], u[2])) * quaternion(c)).normalized(), c);
  }
}

void Tree::way(std::span<const double> from, std::span<const double> to, std::span<double> way) const {
  for (const Link& l : links_) {
    const double *a = from.data() + l.q0, *b = to.data() + l.q0;
    double* w = way.data() + l.v0;
    if (l.dof == 1) w[0] = b[0] - a[0];
    if (l.dof == 6) {
      for (int i = 0; i < 3; ++i) w[i] = b[i] - a[i];
      a += 3, b += 3, w += 3;
    }
    if (l.dof < 3) continue;
    const Vec3 turn = vector_from_rotation(quaternion(b) * quaternion(a).conjugate());
    std::copy(turn.data(), turn.data() + 3, w);
  }
}

void Tree::rate(std::span<const double> q, std::span<const double> v, std::span<double> q_rate) const {
  for (const Link& l : links_) {
    const double *c = q.data() + l.q0, *u = v.data() + l.v0;
    double* r = q_rate.data() + l.q0;
    if (l.dof == 1) r[0] = u[0];
    if (l.dof == 6) {
      for (int a = 0; a < 3; ++a) r[a] = u[a];
      c += 3, u += 3, r += 3;
    }
    if (l.dof >= 3) quaternion_rate(c, u, r);
  }
}

void Tree::twists(const TreePose& pose, std::span<const double> v, std::span<Vec6> V) const {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& l = links_[i];
    const TreePose::Link& p = pose.link[i];
    V[i].setZero();
    if (l.parent >= 0) V[i] = moved_twist(V[l.parent], p.arm);
    with_dof(l.dof, [&](auto k) {
      V[i].noalias() += p.S.leftCols<k>() * Eigen::Map<const Eigen::Matrix<double, k, 1>>(v.data() + l.v0);
    });
  }
}

void Tree::add_wrenches(const TreePose& pose, std::span<Vec6> W, std::span<double> Q) const {
  for (std::size_t i = links_.size(); i-- > 0;) {
    const Link& l = links_[i];
    const TreePose::Link& p = pose.link[i];
    with_dof(l.dof, [&](auto k) {
      Eigen::Map<Eigen::Matrix<double, k, 1>>(Q.data() + l.v0).noalias() += p.S.leftCols<k>().transpose() * W[i];
    });
    if (l.parent < 0) continue;
    W[l.parent] += W[i];
    W[l.parent].tail<3>() += p.arm.cross(Vec3(W[i].head<3>()));
  }
}

void Tree::add_mass(const TreePose& pose, std::span<const double> x, std::span<Vec6> V, std::span<double> y) const {
  twists(pose, x, V);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const TreePose::Link& p = pose.link[i];
    const Vec3 w = V[i].tail<3>(), u = V[i].head<3>();
    const Vec3 momentum = links_[i].mass * (u + w.cross(p.center));
    V[i].head<3>() = momentum;
    V[i].tail<3>() = p.inertia * w + p.center.cross(momentum);
  }
  add_wrenches(pose, V, y);
  for (const Link& l : links_)
    for (int k = 0; k < l.dof; ++k) y[l.v0 + k] += l.armature * x[l.v0 + k];
}

void Tree::accelerations(const TreePose& pose, std::span<const double> v, std::span<const Vec6> V,
                         std::span<const double> rate, std::span<Vec6> a) const {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& l = links_[i];
    const TreePose::Link& p = pose.link[i];
    a[i].setZero();
    if (!rate.empty())
      with_dof(l.dof, [&](auto k) {
        a[i].noalias() += p.S.leftCols<k>() * Eigen::Map<const Eigen::Matrix<double, k, 1>>(rate.data() + l.v0);
      });
    if (l.parent < 0) continue;
    // What turning frames make.
    Vec6 relative = Vec6::Zero();
    with_dof(l.dof, [&](auto k) {
      relative.noalias() = p.S.leftCols<k>() * Eigen::Map<const Eigen::Matrix<double, k, 1>>(v.data() + l.v0);
    });
    const Vec3 w = V[l.parent].tail<3>(), turn = a[l.parent].tail<3>();
    const Vec3 slide = relative.head<3>(), spin = relative.tail<3>();
    a[i].head<3>() += a[l.parent].head<3>() + turn.cross(p.arm) + w.cross(w.cross(p.arm)) + 2.0 * w.cross(slide);
    a[i].tail<3>() += turn + w.cross(spin);
  }
}

void Tree::add_bias(const TreePose& pose, std::span<const double> v, std::span<Vec6> V, std::span<Vec6> a,
                    std::span<double> C) const {
  accelerations(pose, v, V, {}, a);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const TreePose::Link& p = pose.link[i];
    const Vec3 w = V[i].tail<3>(), turn = a[i].tail<3>();
    const Vec3 force = links_[i].mass * (a[i].head<3>() + turn.cross(p.center) + w.cross(w.cross(p.center)));
    V[i].head<3>() = force;
    V[i].tail<3>() = p.inertia * turn + w.cross(p.inertia * w) + p.center.cross(force);
  }
  add_wrenches(pose, V, C);
}

Vec3 Tree::mass_center(const TreePose& pose) const {
  Vec3 moment = Vec3::Zero();
  for (std::size_t i = 0; i < size(); ++i) moment += links_[i].mass * (pose.link[i].origin + pose.link[i].center);
  return moment / mass_;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> Tree::jacobian(const TreePose& pose, int link, const Vec3& arm) const {
  Eigen::Matrix<double, 6, Eigen::Dynamic> J = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, static_cast<int>(nv_));
  const Vec3 x = pose.link[link].origin + arm;
  for (int i = link; i >= 0; i = links_[i].parent)
    for (int k = 0; k < links_[i].dof; ++k)
      J.col(static_cast<int>(links_[i].v0) + k) = moved_twist(pose.link[i].S.col(k), x - pose.link[i].origin);
  return J;
}

Vec6 Tree::momentum(const TreePose& pose, std::span<const Vec6> V, const Vec3& point) const {
  Vec6 sum = Vec6::Zero();
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const TreePose::Link& p = pose.link[i];
    const Vec3 w = V[i].tail<3>();
    const Vec3 linear = links_[i].mass * (V[i].head<3>() + w.cross(p.center));
    sum.head<3>() += linear;
    sum.tail<3>() += p.inertia * w + (p.origin + p.center - point).cross(linear);
  }
  return sum;
}

Mat6 spatial_inertia(double mass, const Vec3& center, const Mat3& inertia) {
  const Mat3 c = skew(center);
  Mat6 I;
  I.topLeftCorner<3, 3>() = mass * Mat3::Identity();
  I.topRightCorner<3, 3>() = -mass * c;
  I.bottomLeftCorner<3, 3>() = mass * c;
  I.bottomRightCorner<3, 3>() = inertia - mass * c * c;
  return I;
}

Mat6 moved_inertia(const Mat6& I, const Vec3& arm) {
  const Mat3 d = skew(arm), A = I.topLeftCorner<3, 3>(), B = I.topRightCorner<3, 3>();
  const Mat3 side = B - A * d;
  Mat6 out;
  out.topLeftCorner<3, 3>() = A;
  out.topRightCorner<3, 3>() = side;
  out.bottomLeftCorner<3, 3>() = side.transpose();
  out.bottomRightCorner<3, 3>() = I.bottomRightCorner<3, 3>() + d * side - B.transpose() * d;
  return out;
}

}  // namespace brim
