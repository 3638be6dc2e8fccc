#include "brim/scene/read_world.h"

#include "brim/scene/body_names.h"
#include "brim/scene/materials.h"

namespace brim {

namespace {

/// What "quality" stands for where the keys themselves are not given.
struct Quality {
  double max_motion_voxels, cg_tolerance;
  int max_passes;
  double constraint_tolerance;
  int constraint_sweeps;
};

Quality read_quality(const Node& n) {
  const std::string word = n.string("quality");
  if (word == "draft") return {2.0, 1e-3, 2, 1e-3, 60};
  if (word == "fine") return {0.5, 1e-6, 8, 1e-5, 1000};
  const WorldOptions o;
  return {o.max_motion_voxels, o.cg_tolerance, o.max_passes, o.constraint_tolerance, o.constraint_sweeps};
}

}  // namespace

WorldOptions read_world(const Node& n) {
  WorldOptions o;
  const Quality quality = read_quality(n);
  const auto number = [&](const char* key, double otherwise) { return n.has(key) ? n.number(key) : otherwise; };
  const auto integer = [&](const char* key, int otherwise) {
    return n.has(key) ? static_cast<int>(n.integer(key)) : otherwise;
  };
  o.environment.gravity = n.vec3("gravity");
  o.time_step = n.number("time_step");
  o.voxel_size = n.number("voxel_size");
  o.ramp_voxels = n.number("ramp_voxels");
  o.stiffness = n.at("stiffness").json().is_string() ? 0.0 : n.number("stiffness");
  o.damping_steps = n.number("damping_steps");
  o.max_motion_voxels = number("max_motion_voxels", quality.max_motion_voxels);
  o.max_substeps = static_cast<int>(n.integer("max_substeps"));
  o.min_substeps = static_cast<int>(n.integer("min_substeps"));
  o.cg_tolerance = number("cg_tolerance", quality.cg_tolerance);
  o.cg_max_iterations = static_cast<int>(n.integer("cg_max_iterations"));
  o.max_passes = integer("max_passes", quality.max_passes);
  o.friction_speed = n.number("friction_speed");
  o.response = read_response(n);
  o.constraint_tolerance = number("constraint_tolerance", quality.constraint_tolerance);
  o.constraint_sweeps = integer("constraint_sweeps", quality.constraint_sweeps);
  o.sleep = n.boolean("sleep");
  o.memory_limit = n.number("memory_limit");
  if (o.min_substeps > o.max_substeps)
    throw n.at("min_substeps")
        .error(fmt::format("{} is not allowed; must be at most max_substeps, {}", o.min_substeps, o.max_substeps));
  return o;
}

LevelOptions read_levels(const Node& n, int steps_per_frame) {
  LevelOptions o;
  for (const auto& [name, level] : n.at("bodies").json().items()) o.bodies[name] = level.get<int>();
  if (n.has("interest")) o.interest = n.vec3("interest");
  o.near = n.number("near");
  o.most = static_cast<int>(n.integer("most"));
  o.budget = 1e-3 * n.number("budget_ms");
  o.average = n.string("reduce") == "average";
  o.interval = steps_per_frame;
  return o;
}

void check_levels(const Node& n, const std::set<std::string>& bodies) {
  for (const auto& [name, level] : n.at("bodies").json().items())
    need_body(n.at("bodies").at(name.c_str()), name, bodies);
}

}  // namespace brim
