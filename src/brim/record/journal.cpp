#include "brim/record/journal.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>

#include "brim/io/regular_file.h"

namespace brim {

namespace {

constexpr char kMagic[] = {'b', 'r', 'i', 'm', 'j', 'n', 'l', '1'};

void (*disk_watch)(const DiskWrite&) = nullptr;

/// FNV-1a, 64 bits (Fowler, Noll and Vo).
std::uint64_t checksum(const std::byte* data, std::size_t size) {
  std::uint64_t h = 14695981039346656037ull;
  for (std::size_t i = 0; i < size; ++i) h = (h ^ static_cast<std::uint64_t>(data[i])) * 1099511628211ull;
  return h;
}

void put(std::vector<std::byte>& to, const void* data, std::size_t size) {
  const auto* from = static_cast<const std::byte*>(data);
  to.insert(to.end(), from, from + size);
}

bool remove_file(const std::string& path) {
  tell_disk_watch({});
  return ::unlink(path.c_str()) == 0 || errno == ENOENT;
}

}  // namespace

void watch_disk_writes(void (*watch)(const DiskWrite&)) { disk_watch = watch; }

void tell_disk_watch(const DiskWrite& write) {
  if (disk_watch != nullptr) disk_watch(write);
}

bool write_at(int file, std::uint64_t at, const void* data, std::size_t size) {
  tell_disk_watch({file, at, data, size});
  const auto* from = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = ::pwrite(file, from, size, static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    from += n, at += static_cast<std::uint64_t>(n), size -= static_cast<std::size_t>(n);
  }
  return true;
}

void Journal::add(std::uint64_t at, const void* data, std::size_t size) {
  const auto* from = static_cast<const std::byte*>(data);
  entries_.push_back({at, std::vector<std::byte>(from, from + size)});
}

std::uint64_t Journal::end() const {
  std::uint64_t end = 0;
  for (const Entry& e : entries_) end = std::max<std::uint64_t>(end, e.at + e.bytes.size());
  return end;
}

void Journal::lay_over(std::uint64_t at, void* data, std::size_t size) const {
  for (const Entry& e : entries_) {
    const std::uint64_t first = std::max(at, e.at), last = std::min<std::uint64_t>(at + size, e.at + e.bytes.size());
    if (first < last)
      std::memcpy(static_cast<std::byte*>(data) + (first - at), e.bytes.data() + (first - e.at), last - first);
  }
}

bool Journal::apply(int file) const {
  return std::ranges::all_of(entries_,
                             [&](const Entry& e) { return write_at(file, e.at, e.bytes.data(), e.bytes.size()); });
}

bool Journal::commit(const std::string& path, int file) {
  if (entries_.empty()) return true;
  struct stat now {};
  if (::fstat(file, &now) != 0) return false;
  const auto length = static_cast<std::uint64_t>(now.st_size);
  std::vector<std::byte> text;
  put(text, kMagic, sizeof kMagic);
  put(text, &length, sizeof length);
  for (const Entry& e : entries_) {
    const std::uint64_t size = e.bytes.size();
    put(text, &e.at, sizeof e.at);
    put(text, &size, sizeof size);
    put(text, e.bytes.data(), e.bytes.size());
  }
  const std::uint64_t sum = checksum(text.data(), text.size());
  put(text, &sum, sizeof sum);

  const std::string beside = path_of(path);
  tell_disk_watch({});
  const int journal = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (journal < 0) return false;
  const bool written = write_at(journal, 0, text.data(), text.size());
  const int why = errno;
  ::close(journal);
  if (!written) {
    remove_file(beside);
    errno = why;
    return false;
  }
  if (!apply(file)) return false;
  entries_.clear();
  return remove_file(beside);
}

void Journal::find(const std::string& path, std::uint64_t length) {
  const std::optional<std::string> held = read_regular_file(path_of(path));
  if (!held) return;
  const std::string& text = *held;
  constexpr std::size_t kHead = sizeof kMagic + sizeof length;
  if (text.size() < kHead + 8 || std::memcmp(text.data(), kMagic, sizeof kMagic) != 0) return;
  const auto number = [&](std::size_t at) {
    std::uint64_t x = 0;
    std::memcpy(&x, text.data() + at, sizeof x);
    return x;
  };
  const std::size_t end = text.size() - 8;
  if (number(end) != checksum(reinterpret_cast<const std::byte*>(text.data()), end)) return;
  if (number(sizeof kMagic) != length) return;
  std::vector<Entry> entries;
  for (std::size_t at = kHead; at < end;) {
    if (end - at < 16) return;
    const std::uint64_t place = number(at), size = number(at + 8);
    at += 16;
    if (size > end - at || place > length || size > length - place) return;
    const auto* from = reinterpret_cast<const std::byte*>(text.data()) + at;
    entries.push_back({place, std::vector<std::byte>(from, from + size)});
    at += size;
  }
  entries_ = std::move(entries);
}

}  // namespace brim
