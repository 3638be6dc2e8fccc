#include "brim/world/momentum_check.h"

#include <algorithm>

#include "brim/core/parallel.h"

namespace brim {

namespace {

struct Resultant {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  ///< about the first contact point of the body
  Vec3 center = Vec3::Zero();
  double magnitude = 0.0, reach = 0.0;
  bool touched = false;
};

}  // namespace

void check_momentum(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                    std::span<const WorldPart> parts, const ContactSet& contacts, std::span<const double> mapped,
                    std::span<const Vec3> force_on_a, StepReport& report) {
  std::vector<Resultant> sum(bodies.size());
  // Points without force do not extend the reach of the forces; supports of fixed bodies are not checked.
  const auto add = [&](std::int32_t part, const Vec3& x, const Vec3& f, double h) {
    if (f == Vec3::Zero() || is_fixed(parts[part])) return;
    Resultant& r = sum[parts[part].body_index];
    if (!r.touched) r.center = x;
    r.touched = true;
    r.force += f;
    r.torque += (x - r.center).cross(f);
    r.magnitude += f.norm();
    r.reach = std::max({r.reach, (x - r.center).norm(), h});
  };
  for (const ContactPair& pair : contacts.pairs)
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      add(pair.part_a, contacts.point[c], force_on_a[c], pair.h);
      add(pair.part_b, contacts.point_b(c), -force_on_a[c], pair.h);
    }
  std::vector<double> motion(first_v.back(), 0.0);
  std::vector<double> linear(bodies.size(), 0.0), angular(bodies.size(), 0.0);
  parallel_for(bodies.size(), [&](std::size_t b) {
    const Resultant& r = sum[b];
    if (!(r.magnitude > 0.0)) return;
    const std::size_t n = first_v[b + 1] - first_v[b];
    const auto v = std::span(motion).subspan(first_v[b], n);
    const auto q = mapped.subspan(first_v[b], n);
    const auto power = [&](const Vec3& t, const Vec3& w, double& out) {
      if (!bodies[b]->rigid_motion(t - w.cross(r.center), w, v)) return false;
      out = 0.0;
      for (std::size_t i = 0; i < n; ++i) out += v[i] * q[i];
      return true;
    };
    for (int a = 0; a < 3; ++a) {
      double p = 0.0;
      if (!power(Vec3::Unit(a), Vec3::Zero(), p)) return;
      linear[b] = std::max(linear[b], std::abs(p - r.force[a]) / r.magnitude);
      if (r.reach > 0.0 && power(Vec3::Zero(), Vec3::Unit(a), p))
        angular[b] = std::max(angular[b], std::abs(p - r.torque[a]) / (r.magnitude * r.reach));
    }
  });
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    report.momentum_error = std::max(report.momentum_error, linear[b]);
    report.angular_error = std::max(report.angular_error, angular[b]);
  }
}

}  // namespace brim
