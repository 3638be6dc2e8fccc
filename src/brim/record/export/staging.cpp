#include "brim/record/export/staging.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "brim/core/error.h"
#include "brim/record/export/output_file.h"

namespace brim::exporting {

namespace fs = std::filesystem;

namespace {

/// Files that an older export in a folder says are its own; names that lead elsewhere are not.
std::vector<std::string> listed_files(const fs::path& folder) {
  std::ifstream in(folder / kManifest);
  const auto manifest = nlohmann::json::parse(in, nullptr, false);
  std::vector<std::string> files = {kManifest};
  if (!manifest.is_object() || !manifest.contains("files") || !manifest["files"].is_array())
    throw InputError(fmt::format("{}: is not the list of an export", (folder / kManifest).string()));
  for (const auto& name : manifest["files"])
    if (name.is_string() && fs::path(name.get<std::string>()).filename() == name.get<std::string>())
      files.push_back(name);
  return files;
}

/// What stands in the way of making the folder anew; empty when nothing does.
std::vector<std::string> check_target(const fs::path& folder, bool force) {
  std::error_code error;
  if (!fs::exists(folder, error)) return {};
  if (!fs::is_directory(folder, error))
    throw InputError(fmt::format("{}: is a file; an export needs a folder", folder.string()));
  if (fs::is_empty(folder, error)) return {};
  if (!fs::exists(folder / kManifest, error))
    throw InputError(
        fmt::format("{}: holds other files; an export needs a new or empty folder, or one with an older "
                    "export",
                    folder.string()));
  if (!force) throw InputError(fmt::format("{}: holds an export already; --force replaces it", folder.string()));
  return listed_files(folder);
}

}  // namespace

Staging::Staging(const std::string& folder, bool force) {
  target_ = fs::absolute(folder).lexically_normal();
  if (target_.filename().empty()) target_ = target_.parent_path();
  old_ = check_target(target_, force);
  staged_ = target_.parent_path() / fmt::format(".{}.{}.part", target_.filename().string(), ::getpid());
  std::error_code error;
  fs::remove_all(staged_, error);
  fs::create_directories(staged_, error);
  if (error) throw InputError(fmt::format("{}: the folder cannot be made: {}", folder, error.message()));
}

Staging::~Staging() {
  std::error_code ignored;
  if (!staged_.empty()) fs::remove_all(staged_, ignored);
}

std::vector<std::string> Staging::files() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(staged_)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

void Staging::commit(const std::string& manifest, const std::vector<std::string>& files) {
  OutputFile list(staged_ / kManifest);
  list.write(manifest);
  list.close();
  std::error_code error;
  const auto need = [&](const fs::path& path) {
    if (error) throw InputError(fmt::format("{}: cannot be written: {}", path.string(), error.message()));
  };
  if (old_.empty()) {
    fs::remove(target_, error);  // an empty folder stands in the way of a rename on some systems
    fs::rename(staged_, target_, error);
    need(target_);
    staged_.clear();
    return;
  }
  for (const std::string& name : old_) fs::remove(target_ / name, error);
  for (const std::string& name : files) {
    fs::rename(staged_ / name, target_ / name, error);
    need(target_ / name);
  }
  // Last, so that a folder with a list always holds what it lists.
  fs::rename(staged_ / kManifest, target_ / kManifest, error);
  need(target_ / kManifest);
}

}  // namespace brim::exporting
