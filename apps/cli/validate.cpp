#include <cstdio>

#include "brim/core/printable.h"
#include "brim/scene/scene.h"
#include "brim/scene/timeline.h"
#include "commands.h"
#include "settings.h"

namespace brim::cli {

void add_validate(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("validate", "check a scene without running it");
  auto path = std::make_shared<std::string>();
  auto settings = std::make_shared<SettingOptions>();
  command->add_option("scene", *path, "scene file (JSON)")->required();
  settings->add_to(*command);
  command->callback([path, settings, &code] {
    const Scene scene = load_scene(*path, settings->read());
    // Building finds what only files and meshes can tell.
    const World world = build_world(scene);
    for (const std::string& line : late_entries(scene))
      std::fprintf(stderr, "brim: warning: %s\n", printable(line).c_str());
    std::printf("%s: good: %d bodies, %zu coordinates, %lld frames of %.6g s\n", path->c_str(), world.body_count(),
                world.state().q.size(), static_cast<long long>(scene.frames), scene.frame_time());
    code = kGood;
  });
}

}  // namespace brim::cli
