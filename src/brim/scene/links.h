#pragma once

#include <string>
#include <vector>

#include "brim/scene/node.h"
#include "brim/world/applied_force.h"
#include "brim/world/attachment.h"
#include "brim/world/touch_rules.h"

namespace brim {

class World;

/// Connections of a scene's bodies: "filters", "attachments", "joints" and "forces" (docs/links.md). Names of bodies
/// are checked when they are applied. "sensors" have their own file (scene/sensors.h).
/// @throws InputError

/// Rules of one entry of "filters". @param groups  "groups" of the scene, or null
std::vector<TouchRule> read_filter(const Node& filter, const Json* groups);
/// Each name of an entry of "filters", and of the groups that it names, must be a body, the stem of numbered copies or
/// a pattern that matches a body. @param root  the scene, for its "groups"  @throws InputError  with the nearest name
void check_filter_names(const Node& filter, const Node& root, const World& world);
Attachment read_attachment(const Node& attachment);
/// An entry of "joints".
Attachment read_joint(const Node& joint);
AppliedForce read_force(const Node& force);

/// Checks these lists of a scene as far as possible without its bodies.
void check_wiring(const Node& root);
/// All rules of a scene.
std::vector<TouchRule> read_filters(const Node& root);
/// Applies attachments, joints and forces of a scene to its bodies, and adds its sensors. @throws InputError likewise
void wire_up(const Node& root, World& world);

}  // namespace brim
