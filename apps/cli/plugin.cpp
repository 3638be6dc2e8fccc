#include <dlfcn.h>
#include <fmt/format.h>

#include <string>
#include <vector>

#include "brim/core/error.h"
#include "commands.h"

namespace brim::cli {

namespace {

/// Loads a library of somebody's own; the kinds of bodies that it adds are known from then on.
void load_plugin(const std::string& path) {
  // Without a slash the system would look in its own folders.
  const std::string file = path.find('/') == std::string::npos ? "./" + path : path;
  if (!dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) throw InputError(fmt::format("--plugin {}: {}", path, dlerror()));
}

}  // namespace

void add_plugins(CLI::App& app) {
  app.add_option_function<std::vector<std::string>>(
         "--plugin",
         [](const std::vector<std::string>& paths) {
           for (const std::string& path : paths) load_plugin(path);
         },
         "library with kinds of bodies of one's own (docs/bodies/your_own.md); may be given more than once")
      ->allow_extra_args(false);
}

}  // namespace brim::cli
