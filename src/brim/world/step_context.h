#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/contact/contact_set.h"
#include "brim/response/penalty.h"
#include "brim/world/contact_maps.h"
#include "brim/world/fill_stage.h"
#include "brim/world/fluid_coupling.h"
#include "brim/world/step_report.h"
#include "brim/world/world_part.h"

namespace brim {

/// Results of the phases of a sub-step before its solve, as input of the solve. Numbers of bodies and of
/// velocities are those of the world: body b has the velocities first_v[b] to first_v[b + 1].
struct StepContext {
  std::span<const std::unique_ptr<Body>> bodies;
  std::span<const std::size_t> first_v;  ///< shape (bodies + 1)
  std::span<const WorldPart> parts;
  Environment environment;
  std::span<const double> v;  ///< [m/s] velocities at the start, shape (nv)
  const ContactSet& contacts;
  const ContactMaps& maps;  ///< of all contacts
  Penalty& response;        ///< begun
  FillStage& fill;          ///< begun; has the forces of its contacts afterwards
  FluidCoupling& coupling;  ///< found
  StepReport& report;
  std::span<const double> impulse{};  ///< [N s] additional impulse, shape (nv) or empty
  /// [kg/s] resistance of air to changes of the velocities of nodes; shape (bodies) or empty, of each (nodes) or empty
  std::span<const std::vector<Mat3>> resistance{};

  /// Follows the arcs of links after a solve: Links::follow_arcs, with the changes of all velocities and of those at
  /// contacts. Empty where none bend.
  std::function<double(std::span<const double>, std::span<const Vec3>)> follow_arcs{};

  /// The velocities of body b in x, shape (nv).
  template <class Vector>
  auto slice(Vector& x, std::size_t b) const {
    return std::span(x).subspan(first_v[b], first_v[b + 1] - first_v[b]);
  }
};

}  // namespace brim
