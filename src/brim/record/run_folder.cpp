#include "brim/record/run_folder.h"

#include <filesystem>
#include <fstream>

#include "brim/record/h5.h"
#include "brim/record/scene_change.h"
#include "brim/record/sensor_csv.h"

namespace brim {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFiles[] = {"run.h5.journal", "run.h5", "run.xdmf", "scene.json", "summary.json", "pulls.json"};

}  // namespace

void write_whole(const std::string& path, const std::string& text) {
  write_whole(path, [&](std::ostream& out) { out << text; });
}

void write_whole(const std::string& path, const std::function<void(std::ostream&)>& write) {
  const std::string part = path + ".part";
  {
    std::ofstream out(part, std::ios::binary);
    write(out);
    out.flush();
    if (!out) throw InputError(fmt::format("{}: cannot be written; is the disk full or the folder protected?", part));
  }
  std::error_code error;
  fs::rename(part, path, error);
  if (error) throw InputError(fmt::format("{}: cannot be written: {}", path, error.message()));
}

void check_run_folder(const std::string& folder, bool force) {
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  if (!fs::is_directory(folder, error)) throw InputError(fmt::format("{}: is a file; a run needs a folder", folder));
  if (fs::is_empty(folder, error)) return;
  if (!fs::exists(fs::path(folder) / "run.h5", error))
    throw InputError(
        fmt::format("{}: holds other files; a run needs a new or empty folder, or one with an older run", folder));
  if (!force)
    throw InputError(fmt::format(
        "{}: holds a run already; --force replaces it (in Python force=True), --resume goes on with it", folder));
}

void remove_run_files(const std::string& folder) {
  std::error_code error;
  for (const char* name : kFiles) fs::remove(fs::path(folder) / name, error);
  for (const std::string& name : sensor_csv_files()) fs::remove(fs::path(folder) / name, error);
  for (const std::string& name : earlier_scenes(folder)) fs::remove(fs::path(folder) / name, error);
}

}  // namespace brim
