#pragma once

#include "brim/body/articulated/tree_model.h"
#include "brim/scene/kinds.h"

namespace brim {

/// Checks of "links", "chain" and "urdf" of an articulated body that the schema cannot express; reads no files.
/// @throws InputError
void check_links(const Node& body);

/// The tree of a body's node, with its base at the origin of the body's frame and lengths scaled.
/// @throws InputError
ArticulatedModel read_links(const Node& body, const BuildContext& context);
ArticulatedModel read_chain(const Node& body, const BuildContext& context);
ArticulatedModel read_urdf_tree(const Node& body, const BuildContext& context);

/// Reads limits, damping, friction, armature and drive of a joint, a chain or a change of a joint; absent keys change
/// nothing.
void read_joint_actions(const Node& n, JointModel& joint);

/// @throws InputError  for a "start" of a joint beyond its limits, [rad or m]
void need_start_within(const Node& joint, double lower, double upper);

/// Number of the link with a name. @throws InputError at the node
int find_link(const ArticulatedModel& model, const Node& name);

}  // namespace brim
