#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace brim {

/// Changes to several places of a file, applied all or none, whenever the writing process is killed:
///
///   run.h5.journal  |magic|length of the file|entries|checksum|   written first, as a whole
///   run.h5          |....AAAA..B....CCCCC....|                    then the places themselves
///                                                                 then the journal is removed
///
/// A truncated journal, or one with a wrong checksum, was never applied: the file is as before. A complete one is
/// applied again by the next process that opens the file for writing, and overlaid in memory by readers.
/// Tests: tests/record/killed_writer_test.cpp
class Journal {
 public:
  struct Entry {
    std::uint64_t at = 0;  ///< [bytes] in the file
    std::vector<std::byte> bytes;
  };

  static std::string path_of(const std::string& file) { return file + ".journal"; }

  void add(std::uint64_t at, const void* data, std::size_t size);
  bool empty() const { return entries_.empty(); }
  void clear() { entries_.clear(); }
  /// End of the last place.
  std::uint64_t end() const;
  /// Overwrites the bytes of [at, at + size) with pending entries.
  void lay_over(std::uint64_t at, void* data, std::size_t size) const;

  /// Writes the journal of the file `path`, then its entries into `file`, then removes the journal.
  /// @return false on a write error, with errno. The file is then as before, or the journal is complete.
  bool commit(const std::string& path, int file);
  /// Reads the complete journal that a killed process left beside the file `path`, if any. @param length  present
  /// length of the file: the journal of another file does not match
  void find(const std::string& path, std::uint64_t length);

 private:
  bool apply(int file) const;
  std::vector<Entry> entries_;
};

/// Writes all of `data` at a place of a file. @return false with errno
bool write_at(int file, std::uint64_t at, const void* data, std::size_t size);

/// For tests: called before each change of a file on disk, with the bytes about to be written, if any.
struct DiskWrite {
  int file = -1;
  std::uint64_t at = 0;
  const void* data = nullptr;
  std::size_t size = 0;
};
void watch_disk_writes(void (*watch)(const DiskWrite&));
void tell_disk_watch(const DiskWrite& write);

}  // namespace brim
