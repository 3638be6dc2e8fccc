#include "brim/record/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "brim/core/error.h"

namespace brim {

FolderLock::FolderLock(const std::string& folder) : file_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (file_ < 0) throw InputError(fmt::format("{}: cannot be opened: {}", folder, std::strerror(errno)));
  if (::flock(file_, LOCK_EX | LOCK_NB) == 0) return;
  const int why = errno;
  if (why != EWOULDBLOCK && why != EINTR) return;  // a file system without locks: as before there were any
  ::close(std::exchange(file_, -1));
  throw InputError(fmt::format("{}: another process is writing this run; wait for its end, or end it", folder));
}

FolderLock::FolderLock(FolderLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(file_, other.file_);
  return *this;
}

FolderLock::~FolderLock() {
  if (file_ >= 0) ::close(file_);
}

}  // namespace brim
