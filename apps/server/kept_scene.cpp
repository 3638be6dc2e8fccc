#include "server/kept_scene.h"

#include <filesystem>
#include <optional>

#include "brim/core/error.h"
#include "brim/io/regular_file.h"
#include "brim/record/h5.h"
#include "brim/scene/document.h"

namespace brim::viewer {

namespace fs = std::filesystem;

namespace {

KeptScene read_kept(const fs::path& folder, const std::string& scene_path) {
  const std::string kept = (folder / "scene.json").string();
  std::optional<std::string> text = read_regular_file(kept);
  if (!text) throw InputError(fmt::format("{}: is not there; a run keeps its scene there", kept));
  std::error_code error;
  const bool known = !scene_path.empty() && fs::is_directory(fs::path(scene_path).parent_path(), error);
  return {std::move(*text), known ? scene_path : kept};
}

}  // namespace

KeptScene kept_scene(const RunReader& run) { return read_kept(fs::path(run.path()).parent_path(), run.scene_path()); }

KeptScene kept_scene(const std::string& folder) {
  const std::string file = (fs::path(folder) / "run.h5").string();
  if (fs::is_regular_file(file) && h5::never_flushed(file)) return read_kept(folder, "");
  return kept_scene(RunReader(folder));
}

std::string python_bodies(const KeptScene& kept) {
  const Json scene = Json::parse(kept.text, nullptr, false, true);
  if (!scene.is_object() || !scene.contains("bodies") || !scene["bodies"].is_array()) return "";
  for (const Json& entry : scene["bodies"])
    if (entry.is_object() && entry.value("kind", Json()) == "python")
      return fmt::format(
          "\"{}\" is a body written in Python (class {}), which only its Python program can build: there "
          "world.restore(brim.Run(folder).state(frame)) goes on from a frame, and world.density gives densities",
          entry.value("name", std::string()), entry.value("class", std::string("unknown")));
  return "";
}

}  // namespace brim::viewer
