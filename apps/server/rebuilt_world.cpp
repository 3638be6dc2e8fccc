#include "server/rebuilt_world.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/scene/kinds.h"
#include "brim/scene/scene.h"
#include "server/kept_scene.h"

namespace brim::viewer {

std::vector<std::string> foreign_kinds(const RunReader& run) {
  std::vector<std::string> foreign;
  for (const RecordedBody& body : run.bodies())
    if (!has_body_kind(body.kind) && std::find(foreign.begin(), foreign.end(), body.kind) == foreign.end())
      foreign.push_back(body.kind);
  return foreign;
}

RebuiltWorld::RebuiltWorld(const RunReader& run) {
  const KeptScene kept = kept_scene(run);
  if (const std::string why = python_bodies(kept); !why.empty())
    throw InputError(fmt::format("{}: {}", run.path(), why));
  try {
    const Scene scene = parse_scene(kept.text, kept.file);
    world_ = std::make_unique<World>(build_world(scene));
  } catch (const InputError&) {
    const std::vector<std::string> foreign = foreign_kinds(run);
    if (foreign.empty()) throw;
    throw InputError(
        fmt::format("{}: the run was made with a plugin: \"{}\" is not a kind of brim's own; name its library, brim "
                    "--plugin FILE ...",
                    run.path(), foreign.front()));
  }
  check_same_world(run, *world_);
}

const World& RebuiltWorld::at(const RunReader& run, std::int64_t frame) {
  if (frame != frame_) {
    frame_ = -1;
    world_->set_state(run.state(frame));
    frame_ = frame;
  }
  return *world_;
}

}  // namespace brim::viewer
