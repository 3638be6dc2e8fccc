#include "brim/scene/plugin.h"

#include <dlfcn.h>

#include <set>
#include <utility>

#include "brim/core/error.h"
#include "brim/scene/kinds.h"

namespace brim {

namespace {

/// Where errors of the plugin that is being loaded are kept; null: none is.
std::string*& plugin_error() {
  static thread_local std::string* error = nullptr;
  return error;
}

/// Opens a library, whose static variables add its kinds.
void* open_library(const std::string& file, std::string& error) {
  std::string* const before = std::exchange(plugin_error(), &error);
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  plugin_error() = before;
  return library;
}

/// What the system's loader says, and what it means for a plugin.
std::string loader_error(const std::string& said) {
  const bool of_brim = said.find("undefined symbol") != std::string::npos && said.find("4brim") != std::string::npos;
  return said + (of_brim ? "; it was built for another version of brim, build it again" : "");
}

}  // namespace

bool keep_plugin_error(const InputError& error) {
  if (plugin_error() == nullptr) return false;
  if (plugin_error()->empty()) *plugin_error() = error.what();
  return true;
}

void load_plugin(const std::string& path) {
  static std::set<void*>& loaded = *new std::set<void*>;  // libraries that have added kinds
  // Without a slash the system would look in its own folders.
  const std::string file = path.find('/') == std::string::npos ? "./" + path : path;
  const std::size_t kinds = body_kind_count();
  std::string error;
  void* const library = open_library(file, error);
  if (library == nullptr) throw InputError(fmt::format("{}: {}", path, loader_error(dlerror())));
  if (!error.empty()) {
    if (body_kind_count() == kinds && !loaded.contains(library)) dlclose(library);
    throw InputError(path + ": " + error);
  }
  if (body_kind_count() > kinds) loaded.insert(library);
  if (loaded.contains(library)) return;
  dlclose(library);
  throw InputError(path + ": is no plugin of brim: it adds no kind of body (add_body_kind, brim/scene/own_kind.h)");
}

}  // namespace brim
