#include "brim/io/dicom_files.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "brim/core/error.h"
#include "brim/io/volume_reader.h"

namespace brim {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostEntries = 200'000;

/// Calls with the path of each regular file until it says that it has seen enough.
template <class Visit>
void visit_files(const std::string& folder, bool deep, const Visit& visit) {
  std::error_code error;
  std::size_t count = 0;
  fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error), end;
  if (error) throw InputError(fmt::format("{}: cannot be opened: {}", folder, error.message()));
  for (; at != end; at.increment(error)) {
    if (error) throw InputError(fmt::format("{}: cannot be read: {}", folder, error.message()));
    if (++count > kMostEntries)
      throw InputError(fmt::format("{}: more than {} entries; name a folder that holds less", folder, kMostEntries));
    if (!deep) at.disable_recursion_pending();
    if (fs::is_regular_file(at->path(), error) && !visit(at->path().string())) return;
  }
}

}  // namespace

bool is_dicom_file(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::ifstream in(path, std::ios::binary);
  char head[132] = {};
  return in.read(head, sizeof head) && std::memcmp(head + 128, "DICM", 4) == 0;
}

DicomFiles find_dicom_files(const std::string& folder, bool deep) {
  DicomFiles files;
  visit_files(folder, deep, [&](const std::string& path) {
    if (!is_dicom_file(path)) return true;
    std::error_code error;
    const auto size = fs::file_size(path, error);
    if (error) return true;
    files.paths.push_back(path);
    files.load.all += static_cast<double>(size);
    files.load.largest = std::max(files.load.largest, static_cast<double>(size));
    return true;
  });
  std::sort(files.paths.begin(), files.paths.end());
  return files;
}

bool holds_dicom(const std::string& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return is_dicom_file(path);
  bool found = false;
  visit_files(path, true, [&](const std::string& file) { return !(found = is_dicom_file(file)); });
  return found;
}

}  // namespace brim
