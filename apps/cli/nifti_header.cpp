#include "nifti_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>

#include "brim/core/error.h"

namespace brim::cli {

namespace {

constexpr std::size_t kHeaderBytes = 348;

/// Reads numbers of the header at byte offsets, turned round when the file has the other byte order.
struct Header {
  std::array<char, kHeaderBytes> bytes{};
  bool swapped = false;

  template <class T>
  T at(std::size_t offset) const {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes.data() + offset, sizeof(T));
    if (swapped) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }
};

const std::map<int, const char*> kTypes = {{2, "uint8"},    {4, "int16"},    {8, "int32"},    {16, "float32"},
                                           {64, "float64"}, {256, "int8"},   {512, "uint16"}, {768, "uint32"},
                                           {1024, "int64"}, {1280, "uint64"}};

}  // namespace

std::string nifti_text(const std::string& path) {
  Header h;
  std::ifstream in(path, std::ios::binary);
  in.read(h.bytes.data(), static_cast<std::streamsize>(h.bytes.size()));
  if (in.gcount() != static_cast<std::streamsize>(h.bytes.size()))
    throw InputError(fmt::format("{}: {} bytes; a NIfTI-1 volume has at least {}", path, in.gcount(), kHeaderBytes));
  if (h.at<std::int32_t>(0) != static_cast<std::int32_t>(kHeaderBytes)) h.swapped = true;
  if (h.at<std::int32_t>(0) != static_cast<std::int32_t>(kHeaderBytes) || std::memcmp(&h.bytes[344], "n", 1) != 0)
    throw InputError(
        fmt::format("{}: is not a NIfTI-1 volume; its header must start with {} and end with \"n+1\" or \"ni1\"", path,
                    kHeaderBytes));
  const int axes = std::clamp<int>(h.at<std::int16_t>(40), 0, 7);
  std::string size, step;
  for (int a = 0; a < axes; ++a) {
    size += fmt::format("{}{}", a > 0 ? " x " : "", h.at<std::int16_t>(42 + 2 * static_cast<std::size_t>(a)));
    if (a < 3)
      step += fmt::format("{}{:.6g}", a > 0 ? " x " : "", std::abs(h.at<float>(80 + 4 * static_cast<std::size_t>(a))));
  }
  const int type = h.at<std::int16_t>(70), unit = h.bytes[123] & 7;
  const auto known = kTypes.find(type);
  return fmt::format(
      "{}: NIfTI-1 volume\n  {} voxels of {} {}\n  {}, {}-endian\n  (volumes cannot be bodies yet)\n", path, size, step,
      unit == 1   ? "m"
      : unit == 2 ? "mm"
      : unit == 3 ? "µm"
                  : "units not given",
      known != kTypes.end() ? known->second : fmt::format("type {}", type), h.swapped ? "big" : "little");
}

}  // namespace brim::cli
