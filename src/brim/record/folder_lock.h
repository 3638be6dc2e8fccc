#pragma once

#include <string>

namespace brim {

/// Exclusive write access to a run folder: a lock on the folder itself (flock), which leaves no file behind and ends
/// with the process, however it ends. Readers take no lock.
/// Tests: tests/record/folder_lock_test.cpp
class FolderLock {
 public:
  FolderLock() = default;
  /// @throws InputError  when the folder cannot be opened or another process, or another lock of this one, holds it
  explicit FolderLock(const std::string& folder);
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  ~FolderLock();

 private:
  int file_ = -1;
};

}  // namespace brim
