#include "server/page_folder.h"

#include <cstdlib>
#include <string>
#include <vector>

#include "brim/core/error.h"

namespace brim::viewer {

namespace fs = std::filesystem;

namespace {

/// Folders in the order in which they are tried.
std::vector<fs::path> candidates(const char* in_source) {
  std::vector<fs::path> list;
  // The built page may lie in the folder `dist` of the script that renders it.
  if (const char* set = std::getenv("BRIM_VIEWER_DIR"); set && *set) return {fs::path(set), fs::path(set) / ".."};
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) list.push_back(program.parent_path().parent_path() / "share/brim/viewer");
  list.push_back(fs::path(BRIM_VIEWER_SOURCE) / in_source);
  return list;
}

/// @param place   where the file must lie in a folder of one's own
/// @param advice  where brim is built as usual
fs::path find(const char* file, const char* in_source, const char* place, const char* advice) {
  std::string looked;
  for (const fs::path& folder : candidates(in_source)) {
    std::error_code error;
    if (fs::is_regular_file(folder / file, error)) return folder;
    looked += (looked.empty() ? "" : ", ") + folder.string();
  }
  if (const char* set = std::getenv("BRIM_VIEWER_DIR"); set && *set)
    throw InputError(fmt::format("BRIM_VIEWER_DIR is {}, where {} is missing; {}", set, file, place));
  throw InputError(fmt::format("{} of the viewer is not in {}; {}", file, looked, advice));
}

}  // namespace

fs::path find_page_folder() {
  return find("index.html", "dist", "it must hold the built page: index.html and assets/ of viewer/dist",
              "build it with ./dev build, or set BRIM_VIEWER_DIR");
}

fs::path find_render_script() {
  return find("render.mjs", "",
              "pictures need it, viewer/render.mjs of brim's sources, beside index.html or in the folder above",
              "it is part of brim's sources (viewer/render.mjs); BRIM_VIEWER_DIR may say where it is") /
         "render.mjs";
}

}  // namespace brim::viewer
