#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace brim {

/// Places of a file that change together, all of them or none, whenever the process that writes them is killed:
///
///   run.h5.journal  |magic|length of the file|entries|checksum|   written first, whole
///   run.h5          |....AAAA..B....CCCCC....|                    then the places themselves
///                                                                 then the journal goes
///
/// A journal that ends early, or whose checksum is wrong, was never taken over: the file is as it was before. A whole
/// one is written into the file again by whoever opens it next for writing, and laid over it by who only reads.
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
  /// Replaces what lies at [at, at + size) by what waits for it.
  void lay_over(std::uint64_t at, void* data, std::size_t size) const;

  /// Writes the journal of the file `path`, then its places into `file`, then removes the journal.
  /// @return false when something cannot be written; errno says why. The file is as before, or the journal is whole.
  bool commit(const std::string& path, int file);
  /// Takes in the whole journal that a killed process left beside the file `path`, if there is one. @param length  of
  /// the file now: that of another file does not fit
  void find(const std::string& path, std::uint64_t length);

 private:
  bool apply(int file) const;
  std::vector<Entry> entries_;
};

/// Writes all of `data` at a place of a file. @return false with errno
bool write_at(int file, std::uint64_t at, const void* data, std::size_t size);

/// For tests: called before each change of a file on disk, with the bytes that are about to be written, if any.
struct DiskWrite {
  int file = -1;
  std::uint64_t at = 0;
  const void* data = nullptr;
  std::size_t size = 0;
};
void watch_disk_writes(void (*watch)(const DiskWrite&));
void tell_disk_watch(const DiskWrite& write);

}  // namespace brim
