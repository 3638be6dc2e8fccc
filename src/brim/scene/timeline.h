#pragma once

#include <map>
#include <string>
#include <vector>

#include "brim/scene/node.h"

namespace brim {

struct Scene;
class World;

/// "timeline" of a scene: edits of its world at given times (docs/editing.md). One entry is one edit of all bodies, or
/// attachments, that its name means.
/// Tests: tests/scene/timeline_test.cpp

/// Checks what can be known without the bodies. @throws InputError
void check_timeline(const Node& root, const Scene& scene);
/// Entries that the run does not get to, since its last step begins before them: a line for each, with its place.
std::vector<std::string> late_entries(const Scene& scene);
/// Schedules all of it. @throws InputError  for names that mean nothing and bodies that cannot be edited so
void schedule_timeline(const Scene& scene, World& world);

}  // namespace brim
