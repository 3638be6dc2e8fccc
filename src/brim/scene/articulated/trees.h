#pragma once

#include "brim/body/articulated/tree_model.h"
#include "brim/scene/kinds.h"

namespace brim {

/// What the schema cannot say about "links", "chain" and "urdf" of an articulated body; reads no files.
/// @throws InputError
void check_links(const Node& body);

/// The tree of a body's node, its base at the origin of the body's frame, lengths scaled.
/// @throws InputError
ArticulatedModel read_links(const Node& body, const BuildContext& context);
ArticulatedModel read_chain(const Node& body, const BuildContext& context);
ArticulatedModel read_urdf_tree(const Node& body, const BuildContext& context);

/// Limits, damping, friction, armature and drive, as a joint, a chain and a change of a joint write them; what is
/// absent stays.
void read_joint_actions(const Node& n, JointModel& joint);

/// Number of the link with a name. @throws InputError at the node
int find_link(const ArticulatedModel& model, const Node& name);

}  // namespace brim
