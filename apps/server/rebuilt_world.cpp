#include "server/rebuilt_world.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include "brim/core/error.h"
#include "brim/io/regular_file.h"
#include "brim/scene/kinds.h"
#include "brim/scene/scene.h"

namespace brim::viewer {

namespace fs = std::filesystem;

std::vector<std::string> foreign_kinds(const RunReader& run) {
  std::vector<std::string> foreign;
  for (const RecordedBody& body : run.bodies())
    if (!has_body_kind(body.kind) && std::find(foreign.begin(), foreign.end(), body.kind) == foreign.end())
      foreign.push_back(body.kind);
  return foreign;
}

RebuiltWorld::RebuiltWorld(const RunReader& run) {
  const fs::path kept = fs::path(run.path()).parent_path() / "scene.json";
  const std::optional<std::string> text = read_regular_file(kept.string());
  if (!text)
    throw InputError(
        fmt::format("{}: is not there; the densities of a run are made from the scene that it keeps", kept.string()));
  // Paths inside start from where the scene was read, if that is still there.
  std::error_code error;
  const bool known = !run.scene_path().empty() && fs::is_directory(fs::path(run.scene_path()).parent_path(), error);
  try {
    const Scene scene = parse_scene(*text, known ? run.scene_path() : kept.string());
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
