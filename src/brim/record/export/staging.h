#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace brim::exporting {

/// Name of the file in which an export lists what it wrote.
inline constexpr const char* kManifest = "export.json";

/// A folder created atomically: files are written into a folder beside it, which commit() moves to its place.
class Staging {
 public:
  /// @param folder  must not exist, be empty, or (with force) contain only an older export
  /// @throws InputError
  Staging(const std::string& folder, bool force);
  /// Removes everything not committed.
  ~Staging();
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;

  const std::filesystem::path& folder() const { return staged_; }
  /// Names of the files written so far, sorted.
  std::vector<std::string> files() const;
  /// Moves the files to their place and removes those of an older export. @param manifest  text of export.json
  void commit(const std::string& manifest, const std::vector<std::string>& files);

 private:
  std::filesystem::path target_, staged_;
  std::vector<std::string> old_;  ///< files of the replaced export
};

}  // namespace brim::exporting
