#include "server/array_message.h"

#include <bit>
#include <cstring>
#include <limits>

#include "brim/core/error.h"

namespace brim::viewer {

// Numbers are copied as they lie in memory.
static_assert(std::endian::native == std::endian::little);

namespace {

constexpr std::size_t kHeaderBytes = 16;
constexpr std::size_t kEntryBytes = 56;
constexpr std::size_t kNameBytes = 32;
constexpr std::uint32_t kVersion = 1;

std::size_t align8(std::size_t n) { return (n + 7) & ~std::size_t{7}; }

template <class T>
void put(std::string& out, std::size_t at, T value) {
  std::memcpy(&out[at], &value, sizeof value);
}

}  // namespace

void ArrayMessage::add(std::string_view name, const float* data, std::size_t rows, std::size_t columns, int body) {
  add_raw(name, 1, body, data, rows, columns, sizeof *data);
}
void ArrayMessage::add(std::string_view name, const std::int32_t* data, std::size_t rows, std::size_t columns,
                       int body) {
  add_raw(name, 2, body, data, rows, columns, sizeof *data);
}
void ArrayMessage::add(std::string_view name, const double* data, std::size_t rows, std::size_t columns, int body) {
  add_raw(name, 3, body, data, rows, columns, sizeof *data);
}

void ArrayMessage::add_raw(std::string_view name, std::uint32_t type, int body, const void* data, std::size_t rows,
                           std::size_t columns, std::size_t element) {
  BRIM_CHECK(name.size(), <, kNameBytes);
  const std::size_t size = rows * columns * element;
  Array a{std::string(name), type, body, rows, columns, std::string(size, '\0')};
  if (size > 0) std::memcpy(a.data.data(), data, size);
  arrays_.push_back(std::move(a));
}

std::string ArrayMessage::bytes() const {
  std::size_t end = align8(kHeaderBytes + kEntryBytes * arrays_.size());
  std::vector<std::size_t> offsets;
  for (const Array& a : arrays_) {
    offsets.push_back(end);
    end = align8(end + a.data.size());
  }
  if (end > std::numeric_limits<std::uint32_t>::max())
    throw InputError(fmt::format("a frame of {} bytes is larger than the viewer can show (4 GiB)", end));
  std::string out(end, '\0');
  std::memcpy(out.data(), "BRMA", 4);
  put(out, 4, kVersion);
  put(out, 8, static_cast<std::uint32_t>(arrays_.size()));
  put(out, 12, static_cast<std::uint32_t>(end));
  for (std::size_t i = 0; i < arrays_.size(); ++i) {
    const Array& a = arrays_[i];
    const std::size_t at = kHeaderBytes + i * kEntryBytes;
    std::memcpy(&out[at], a.name.data(), a.name.size());
    put(out, at + 32, a.type);
    put(out, at + 36, a.body);
    put(out, at + 40, static_cast<std::uint32_t>(a.rows));
    put(out, at + 44, static_cast<std::uint32_t>(a.columns));
    put(out, at + 48, static_cast<std::uint64_t>(offsets[i]));
    if (!a.data.empty()) std::memcpy(&out[offsets[i]], a.data.data(), a.data.size());
  }
  return out;
}

}  // namespace brim::viewer
