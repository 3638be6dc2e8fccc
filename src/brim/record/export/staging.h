#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace brim::exporting {

/// The name of the file in which an export says what it wrote.
inline constexpr const char* kManifest = "export.json";

/// A folder that appears whole or not at all: files are written into one beside it, which commit() moves to its place.
class Staging {
 public:
  /// @param folder  must not exist, be empty, or (with force) hold an older export and nothing more
  /// @throws InputError
  Staging(const std::string& folder, bool force);
  /// Removes what was not committed.
  ~Staging();
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;

  const std::filesystem::path& folder() const { return staged_; }
  /// Names of the files written so far, sorted.
  std::vector<std::string> files() const;
  /// Moves the files to their place; those of an older export go. @param manifest  text of export.json
  void commit(const std::string& manifest, const std::vector<std::string>& files);

 private:
  std::filesystem::path target_, staged_;
  std::vector<std::string> old_;  ///< files of the export that is replaced
};

}  // namespace brim::exporting
