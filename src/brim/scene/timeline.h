#pragma once

#include <map>
#include <string>
#include <vector>

#include "brim/scene/node.h"

namespace brim {

struct Scene;
class World;

/// "timeline" of a scene: edits of its world at given times (docs/editing.md). One entry is one edit of all bodies, or
/// attachments, that its name matches.
/// Tests: tests/scene/timeline_test.cpp

/// Checks as far as possible without the bodies. @throws InputError
void check_timeline(const Node& root, const Scene& scene);
/// Entries after the start of the run's last step, which never happen: one line each, with its place.
std::vector<std::string> late_entries(const Scene& scene);
/// Schedules all entries. @throws InputError  for names without match and bodies that cannot be edited so
void schedule_timeline(const Scene& scene, World& world);

}  // namespace brim
