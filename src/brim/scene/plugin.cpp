#include "brim/scene/plugin.h"

#include <dlfcn.h>

#include <set>

#include "brim/core/error.h"
#include "brim/scene/kinds.h"

namespace brim {

void load_plugin(const std::string& path) {
  static std::set<void*>& loaded = *new std::set<void*>;  // libraries that have added kinds
  // Without a slash the system would look in its own folders.
  const std::string file = path.find('/') == std::string::npos ? "./" + path : path;
  const std::size_t kinds = body_kind_count();
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw InputError(fmt::format("{}: {}", path, dlerror()));
  if (body_kind_count() > kinds) loaded.insert(library);
  if (loaded.contains(library)) return;
  dlclose(library);
  throw InputError(path + ": is no plugin of brim: it adds no kind of body (add_body_kind, brim/scene/own_kind.h)");
}

}  // namespace brim
