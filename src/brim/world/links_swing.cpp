#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "brim/body/rigid_frame.h"
#include "brim/body/solid_of.h"
#include "brim/core/interface_of.h"
#include "brim/world/body_motion.h"
#include "brim/world/links.h"

namespace brim {

namespace {

/// [s] The fastest swing is remembered as exp(−t / kFading).
constexpr double kFading = 0.3;

/// The body of a part, if its matter turns with its coordinates alone: a single solid that can move.
const Body* turning_solid(const WorldPart& part) {
  const Body* body = part.body;
  return !body->immobile() && body->part_count() == 1 && solid_of(*body, 0) != nullptr ? body : nullptr;
}

/// Inertia about the centre c, [kg m²].
Mat3 inertia_of(const Body& body, const Vec3& c) {
  Mat3 inertia;
  std::vector<double> v(body.v_size());
  for (int k = 0; k < 3; ++k) {
    const Vec3 w = Vec3::Unit(k);
    body.rigid_motion(c.cross(w), w, v);
    inertia.col(k) = body.angular_momentum(v);
  }
  return 0.5 * (inertia + inertia.transpose());
}

}  // namespace

void Links::find_swing(std::span<const WorldPart> parts, const ContactSet& set, std::span<const Vec3> force) {
  // −∂τ/∂θ = (r·f) 1 − (r fᵀ + f rᵀ)/2 of all links of a solid.
  struct Solid {
    const Body* body = nullptr;
    Vec3 center = Vec3::Zero();
    Mat3 stiffness = Mat3::Zero();
  };
  std::map<int, Solid> solids;  // by body
  const auto add = [&](std::int32_t part, const Vec3& x, const Vec3& f) {
    const Body* body = part < 0 ? nullptr : turning_solid(parts[part]);
    if (body == nullptr) return;
    auto [at, fresh] = solids.try_emplace(parts[part].body_index);
    Solid& solid = at->second;
    if (fresh) solid.body = body, solid.center = middle_of(*body);
    const Vec3 r = x - solid.center;
    solid.stiffness += r.dot(f) * Mat3::Identity() - 0.5 * (r * f.transpose() + f * r.transpose());
  };
  const std::size_t first = set.first_link();
  for (std::size_t i = 0; i < ties_.size(); ++i) {
    const Link& link = *links_[ties_[i].link];
    add(link.part_a, set.point[first + i], force[first + i]);
    add(link.part_b, set.link_point_b[i], -force[first + i]);
  }
  double fastest = 0.0;  // [1/s²]
  for (const auto& [_, solid] : solids) {
    const Mat3 inertia = inertia_of(*solid.body, solid.center);
    const Eigen::GeneralizedSelfAdjointEigenSolver<Mat3> eigen(solid.stiffness, inertia, Eigen::EigenvaluesOnly);
    if (eigen.info() == Eigen::Success) fastest = std::max(fastest, eigen.eigenvalues().maxCoeff());
  }
  swing_now_ = std::sqrt(fastest);
}

double Links::spin_pieces(std::span<const WorldPart> parts, std::span<const double> v,
                          std::span<const std::size_t> first_v, double dt) const {
  double fastest = 0.0;
  for (const auto& link : links_)
    for (const std::int32_t part : {link->part_a, link->part_b}) {
      if (link->broken || part < 0 || interface_of<RigidFrame>(*parts[part].body) == nullptr) continue;
      const double* own = v.data() + first_v[parts[part].body_index];
      fastest = std::max(fastest, Vec3(own[3], own[4], own[5]).norm());
    }
  return dt * fastest / kSpin;
}

void Links::remember(double dt) {
  const bool none = links_.empty() || ties_.empty();
  swing_ = none ? 0.0 : std::max(swing_ * std::exp(-dt / kFading), swing_now_);
  swing_now_ = 0.0;
  last_substep_ = none ? 0.0 : dt;
}

}  // namespace brim
