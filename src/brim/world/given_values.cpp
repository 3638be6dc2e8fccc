#include "brim/world/given_values.h"

#include <cmath>
#include <limits>

#include "brim/body/rigid_frame.h"
#include "brim/core/error.h"
#include "brim/core/interface_of.h"

namespace brim {

namespace {

constexpr double kNoBound = std::numeric_limits<double>::infinity();

void need_finite(const char* of, const Body& body, const char* what, std::span<const double> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!std::isfinite(numbers[i]))
      throw InputError(
          fmt::format("{}: {} {} of '{}' is {}; all must be finite", of, what, i, body.name(), numbers[i]));
}

/// A size in metres that may be absent, as zero or infinity.
void need_size(const std::string& of, const char* what, double value, bool good) {
  if (!good) throw InputError(fmt::format("{}: {} {} is not allowed; must be above 0 [m]", of, what, value));
}

}  // namespace

void need_number(const std::string& of, const char* what, double value, double least, double most) {
  if (value >= least && value <= most && std::isfinite(value)) return;
  throw InputError(std::isinf(most)
                       ? fmt::format("{}: {} {} is not allowed; must be a number from {}", of, what, value, least)
                       : fmt::format("{}: {} {} is not allowed; must be from {} to {}", of, what, value, least, most));
}

void need_material(const std::string& of, const Material& material) {
  need_number(of, "friction", material.friction, 0.0, kNoBound);
  need_number(of, "restitution", material.restitution, 0.0, 1.0);
  need_number(of, "rolling_resistance", material.rolling_resistance, 0.0, kNoBound);
}

void need_pair_material(const std::string& of, const PairMaterial& pair) {
  if (!(pair.friction < 0.0)) need_number(of, "friction", pair.friction, 0.0, kNoBound);
  if (!(pair.restitution < 0.0)) need_number(of, "restitution", pair.restitution, 0.0, 1.0);
  if (!(pair.rolling_resistance < 0.0)) need_number(of, "rolling_resistance", pair.rolling_resistance, 0.0, kNoBound);
  need_number(of, "stiffness", pair.stiffness, 0.0, kNoBound);
}

void need_parts(const Body& body) {
  for (int p = 0; p < body.part_count(); ++p) {
    const PartInfo part = body.part(p);
    const std::string of = fmt::format("part {} of '{}'", p, body.name());
    need_size(of, "voxel_size", part.voxel_size, part.voxel_size >= 0.0 && std::isfinite(part.voxel_size));
    need_size(of, "thickness", part.thickness, part.thickness > 0.0);
    need_material(fmt::format("material '{}' of '{}'", part.material.name, body.name()), part.material);
  }
}

void need_coordinates(const char* of, const Body& body, std::span<const double> q, std::span<const double> v) {
  need_finite(of, body, "coordinate", q);
  if (interface_of<RigidFrame>(body) != nullptr && q.size() == 7) {
    const double length = Eigen::Map<const Eigen::Vector4d>(q.data() + 3).stableNorm();
    if (!(length > 1e-3 && length < 1e3))
      throw InputError(
          fmt::format("{}: the quaternion of '{}' has length {}; must be near 1", of, body.name(), length));
  }
  need_finite(of, body, "velocity", v);
}

void need_options(const WorldOptions& options) {
  const auto need = [](const char* what, double value, bool good) {
    if (!good) throw InputError(fmt::format("world: {} = {} is out of range", what, value));
  };
  const auto from_zero = [&](const char* what, double value) {
    need(what, value, value >= 0.0 && std::isfinite(value));
  };
  need("time_step [s]", options.time_step, options.time_step > 0.0 && std::isfinite(options.time_step));
  from_zero("voxel_size [m]", options.voxel_size);
  need("ramp_voxels", options.ramp_voxels, options.ramp_voxels >= 2.0 && options.ramp_voxels <= 4.0);
  from_zero("stiffness [Pa]", options.stiffness);
  from_zero("damping_steps", options.damping_steps);
  need("max_motion_voxels", options.max_motion_voxels,
       options.max_motion_voxels > 0.0 && options.max_motion_voxels <= 2.0);
  need("max_substeps", options.max_substeps, options.max_substeps >= 1);
  need("min_substeps", options.min_substeps, options.min_substeps >= 1);
  need("cg_tolerance", options.cg_tolerance, options.cg_tolerance > 0.0 && options.cg_tolerance < 1.0);
  from_zero("friction_speed [m/s]", options.friction_speed);
  from_zero("constraint_tolerance", options.constraint_tolerance);
  need("constraint_sweeps", options.constraint_sweeps, options.constraint_sweeps >= 1);
  need("memory_limit [bytes]", options.memory_limit, options.memory_limit > 0.0);
  for (const double g : options.environment.gravity) need("gravity [m/s²]", g, std::isfinite(g));
  for (const auto& [names, pair] : options.pair_materials)
    need_pair_material(fmt::format("materials '{}' and '{}'", names.first, names.second), pair);
}

}  // namespace brim
