#include "brim/body/rod/rod_body.h"

#include "brim/body/particles/line_contact.h"
#include "brim/core/error.h"

namespace brim {

namespace {

/// ParticleSet::least_inertia of a line: nodes off it by some hundredth of its length.
constexpr double kLeastInertia = 1e-4;

}  // namespace

RodBody::Line RodBody::make_line(const std::vector<Vec3>& nodes, const RodOptions& o) {
  require_positive("rod", "radius", o.radius);
  require_positive("rod", "linear density", o.linear_density);
  require_positive("rod", "stretch stiffness", o.stretch);
  require_not_negative("rod", "bending stiffness", o.bending);
  const std::size_t least = o.closed ? 3 : 2, n = nodes.size();
  if (n < least) throw InputError(fmt::format("rod: {} nodes; at least {} are needed", n, least));
  Line line;
  line.mass.assign(n, 0.0);
  for (std::size_t i = 0; i < (o.closed ? n : n - 1); ++i) {
    const std::size_t j = (i + 1) % n;
    const double length = (nodes[j] - nodes[i]).norm();
    if (!(length > 0.0) || !std::isfinite(length))
      throw InputError(fmt::format("rod: nodes {} and {} are {} m apart; the distance must be positive", i, j, length));
    line.springs.push_back({{static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)}, o.stretch / length, length});
    line.mass[i] += 0.5 * o.linear_density * length;
    line.mass[j] += 0.5 * o.linear_density * length;
  }
  return line;
}

RodBody::RodBody(std::vector<Vec3> nodes, RodOptions options) : RodBody(nodes, make_line(nodes, options), options) {}

RodBody::RodBody(std::vector<Vec3> nodes, Line line, const RodOptions& options)
    : StrainDampedBody(std::move(nodes), std::move(line.mass), options), stretch_(line.springs, rest_) {
  const auto n = static_cast<std::int32_t>(rest_.size());
  std::vector<std::array<std::int32_t, 3>> triples;
  for (std::int32_t i = options.closed ? 0 : 1; i < (options.closed ? n : n - 1); ++i)
    triples.push_back({(i + n - 1) % n, i, (i + 1) % n});
  bending_ = RodBending(triples, rest_, options.bending, !options.rests_straight);

  BlockMatrix pattern;
  pattern.begin(particle_count());
  pattern.add_elements(stretch_.nodes(), 2);
  pattern.add_elements(bending_.nodes(), 3);
  pattern.finish();
  share_pattern(std::move(pattern));
  least_inertia_ = kLeastInertia;
  stretch_.find_pairs(stiffness_);
  bending_.find_pairs(stiffness_);
  force_.assign(particle_count(), Vec3::Zero());

  PartInfo part;
  part.voxel_size = options.radius;
  part.areal_mass = options.linear_density / (2.0 * options.radius);
  part.thickness = 2.0 * options.radius, part.lines = true;
  std::vector<std::array<std::int32_t, 2>> segments;
  for (const Spring& s : line.springs) segments.push_back(s.node), length_ += s.length;
  set_contact(std::make_unique<LineContact>(segments, options.radius), part);
  display_.kind = Display::Kind::Lines;
  display_.lines = std::move(segments);
  display_.radius = options.radius;
}

void RodBody::add_inner() {
  stretch_.add(x_, force_, stiffness_, damper_);
  bending_.add(x_, force_, stiffness_, damper_);
}

}  // namespace brim
