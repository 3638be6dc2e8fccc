#include "brim/record/upgrade_run.h"

#include <filesystem>

#include "brim/io/regular_file.h"
#include "brim/record/run_writer.h"

namespace brim {

namespace fs = std::filesystem;

void upgrade_run(const std::string& folder, World& world) {
  const fs::path part = fs::path(folder) / ".run.h5.part";
  std::error_code error;
  fs::remove_all(part, error);
  {
    const RunReader old(folder);
    const std::string scene = read_regular_file((fs::path(folder) / "scene.json").string()).value_or("");
    RunWriter writer(part.string(), world,
                     {old.scene_name(), scene, old.frame_time(), old.steps_per_frame(), old.scene_path()});
    for (std::int64_t f = 0; f < old.frames(); ++f) {
      world.set_state(old.state(f));
      writer.add(world, old.report(f), old.steps(f), old.samples(f), old.contacts(f), old.tiles(f));
    }
    writer.flush();
  }
  fs::rename(part / "run.h5", fs::path(folder) / "run.h5", error);
  if (error) throw InputError(fmt::format("{}: cannot be written: {}", folder, error.message()));
  fs::remove_all(part, error);
}

}  // namespace brim
