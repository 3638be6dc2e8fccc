#include "brim/record/export/zip_file.h"

#include <array>

namespace brim::exporting {

namespace {

/// CRC-32 of ISO 3309, reflected, polynomial 0xEDB88320.
std::uint32_t crc32(std::uint32_t crc, const unsigned char* data, std::size_t bytes) {
  static const auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t n = 0; n < 256; ++n) {
      std::uint32_t c = n;
      for (int k = 0; k < 8; ++k) c = (c & 1u) ? 0xEDB88320u ^ (c >> 1) : c >> 1;
      table[n] = c;
    }
    return table;
  }();
  crc = ~crc;
  for (std::size_t i = 0; i < bytes; ++i) crc = kTable[(crc ^ data[i]) & 0xffu] ^ (crc >> 8);
  return ~crc;
}

template <class... T>
std::string bytes_of(T... numbers) {
  std::string out;
  (out.append(reinterpret_cast<const char*>(&numbers), sizeof numbers), ...);
  return out;
}

using U16 = std::uint16_t;
using U32 = std::uint32_t;
using U64 = std::uint64_t;

constexpr U32 kIn64 = 0xffffffffu;  // "look into the 64-bit field"
constexpr U16 kVersion = 45;        // the first with that field
constexpr U16 kUtf8 = 1u << 11;
constexpr U16 kDay = (0 << 9) | (1 << 5) | 1;  // the first of 1980: equal runs make equal files

}  // namespace

void ZipFile::begin(const std::string& name) {
  members_.push_back({name, file_.size(), 0, 0});
  file_.write(bytes_of(U32{0x04034b50}, kVersion, kUtf8, U16{0}, U16{0}, kDay, U32{0}, kIn64, kIn64,
                       static_cast<U16>(name.size()), U16{20}));
  file_.write(name);
  file_.write(bytes_of(U16{1}, U16{16}, U64{0}, U64{0}));
}

void ZipFile::write(const void* data, std::size_t bytes) {
  Member& m = members_.back();
  m.crc = crc32(m.crc, static_cast<const unsigned char*>(data), bytes);
  m.size += bytes;
  file_.write(data, bytes);
}

void ZipFile::end() {
  const Member& m = members_.back();
  file_.patch(m.at + 14, &m.crc, sizeof m.crc);
  const std::string sizes = bytes_of(m.size, m.size);
  file_.patch(m.at + 30 + m.name.size() + 4, sizes.data(), sizes.size());
}

void ZipFile::close() {
  const U64 start = file_.size();
  for (const Member& m : members_) {
    file_.write(bytes_of(U32{0x02014b50}, kVersion, kVersion, kUtf8, U16{0}, U16{0}, kDay, m.crc, kIn64, kIn64,
                         static_cast<U16>(m.name.size()), U16{28}, U16{0}, U16{0}, U16{0}, U32{0}, kIn64));
    file_.write(m.name);
    file_.write(bytes_of(U16{1}, U16{24}, m.size, m.size, m.at));
  }
  const U64 end = file_.size(), count = members_.size();
  file_.write(bytes_of(U32{0x06064b50}, U64{44}, kVersion, kVersion, U32{0}, U32{0}, count, count, end - start, start));
  file_.write(bytes_of(U32{0x07064b50}, U32{0}, end, U32{1}));
  file_.write(bytes_of(U32{0x06054b50}, U16{0}, U16{0}, U16{0xffff}, U16{0xffff}, kIn64, kIn64, U16{0}));
  file_.close();
}

}  // namespace brim::exporting
