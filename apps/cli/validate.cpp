#include <cstdio>

#include "brim/body/own/own_body_check.h"
#include "brim/core/printable.h"
#include "brim/scene/errors.h"
#include "brim/scene/scene.h"
#include "brim/scene/timeline.h"
#include "commands.h"
#include "settings.h"

namespace brim::cli {

namespace {

/// Holds the functions of own bodies against each other. @throws InputErrors
void check_own_bodies(const World& world) {
  std::vector<std::string> found;
  for (int b = 0; b < world.body_count(); ++b)
    if (const auto* own = dynamic_cast<const OwnBody*>(&world.body(b)))
      for (std::string& text : check_own_body(*own)) found.push_back(std::move(text));
  if (!found.empty()) throw InputErrors(std::move(found));
}

}  // namespace

void add_validate(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("validate", "check a scene without running it");
  auto path = std::make_shared<std::string>();
  auto settings = std::make_shared<SettingOptions>();
  command->add_option("scene", *path, "scene file (JSON)")->required();
  settings->add_to(*command);
  command->callback([path, settings, &code] {
    const Scene scene = load_scene(*path, settings->read());
    // Building finds what only files and meshes can tell.
    World world = build_world(scene);
    check_own_bodies(world);
    for (const std::string& line : late_entries(scene))
      std::fprintf(stderr, "brim: warning: %s\n", printable(line).c_str());
    for (const Warning& warning : world.material_warnings())
      std::fprintf(stderr, "brim: warning: %s\n", printable(warning.message).c_str());
    std::printf("%s: good: %d bodies, %zu coordinates, %lld frames of %.6g s\n", path->c_str(), world.body_count(),
                world.state().q.size(), static_cast<long long>(scene.frames), scene.frame_time());
    code = kGood;
  });
}

}  // namespace brim::cli
