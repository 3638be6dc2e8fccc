#include "brim/io/byte_source.h"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "brim/core/error.h"

namespace brim {

struct ByteSource::Handle {
  int plain = -1;
  gzFile packed = nullptr;
  ~Handle() {
    if (packed != nullptr) gzclose_r(packed);
    if (plain >= 0) ::close(plain);
  }
};

ByteSource::ByteSource(const std::string& path, std::size_t offset, bool gzip)
    : path_(path), handle_(std::make_unique<Handle>()) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) throw InputError(path + ": cannot be opened");
  handle_->plain = file;
  if (::lseek(file, static_cast<off_t>(offset), SEEK_SET) < 0)
    throw InputError(path + ": cannot be read from its middle");
  if (!gzip) return;
  handle_->packed = gzdopen(file, "rb");
  if (handle_->packed == nullptr) throw InputError(path + ": cannot be unpacked");
  handle_->plain = -1;  // belongs to the packed stream now
  gzbuffer(handle_->packed, 1u << 17);
}

ByteSource::~ByteSource() = default;
ByteSource::ByteSource(ByteSource&&) noexcept = default;

std::size_t ByteSource::read_some(void* to, std::size_t n) {
  constexpr std::size_t kMost = std::size_t{1} << 26;
  auto* out = static_cast<char*>(to);
  std::size_t got = 0;
  while (got < n) {
    const std::size_t want = std::min(n - got, kMost);
    const std::ptrdiff_t r = handle_->packed != nullptr
                                 ? gzread(handle_->packed, out + got, static_cast<unsigned>(want))
                                 : ::read(handle_->plain, out + got, want);
    if (r < 0) throw InputError(path_ + ": the data cannot be read; the file is broken");
    if (r == 0) break;
    got += static_cast<std::size_t>(r);
  }
  done_ += got;
  return got;
}

void ByteSource::read(void* to, std::size_t n) {
  const std::size_t before = done_;
  const std::size_t got = read_some(to, n);
  if (got < n)
    throw InputError(fmt::format("{}: the file is cut short: {} bytes are there where {} are needed", path_,
                                 before + got, before + n));
}

void ByteSource::skip(std::size_t n) {
  std::vector<char> waste(std::min(n, std::size_t{1} << 16));
  while (n > 0) {
    const std::size_t part = std::min(n, waste.size());
    read(waste.data(), part);
    n -= part;
  }
}

bool is_gzip(const std::string& path) {
  unsigned char magic[2] = {0, 0};
  ByteSource source(path, 0, false);
  return source.read_some(magic, 2) == 2 && magic[0] == 0x1f && magic[1] == 0x8b;
}

std::size_t file_size(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) throw InputError(path + ": cannot be opened");
  return static_cast<std::size_t>(size);
}

}  // namespace brim
