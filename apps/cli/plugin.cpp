#include "brim/scene/plugin.h"

#include <string>
#include <vector>

#include "brim/core/error.h"
#include "commands.h"

namespace brim::cli {

namespace {

void load(const std::string& path) {
  try {
    load_plugin(path);
  } catch (const InputError& error) {
    throw InputError(std::string("--plugin ") + error.what());
  }
}

}  // namespace

void add_plugins(CLI::App& app) {
  app.add_option_function<std::vector<std::string>>(
         "--plugin",
         [](const std::vector<std::string>& paths) {
           for (const std::string& path : paths) load(path);
         },
         "library with kinds of bodies of one's own (docs/bodies/your_own.md); may be given more than once")
      ->allow_extra_args(false);
}

}  // namespace brim::cli
