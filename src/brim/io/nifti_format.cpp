#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>

#include "brim/core/error.h"
#include "brim/io/byte_source.h"
#include "brim/io/volume_formats.h"

namespace brim {

namespace {

constexpr std::size_t kHeaderBytes = 348;
static_assert(std::endian::native == std::endian::little);

/// Numbers of the header at the byte offsets of nifti1.h (NIfTI-1.1 standard), turned round when the file has the other
/// byte order.
struct Header {
  std::array<char, kHeaderBytes> bytes{};
  bool swapped = false;

  template <class T>
  T at(std::size_t offset, std::size_t i = 0) const {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes.data() + offset + i * sizeof(T), sizeof(T));
    if (swapped) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }
  template <class T>
  void put(std::size_t offset, T value) {
    std::memcpy(bytes.data() + offset, &value, sizeof(T));
  }
};

const std::map<int, VoxelType> kNiftiTypes = {
    {2, VoxelType::UInt8},    {4, VoxelType::Int16},    {8, VoxelType::Int32},    {16, VoxelType::Float32},
    {64, VoxelType::Float64}, {256, VoxelType::Int8},   {512, VoxelType::UInt16}, {768, VoxelType::UInt32},
    {1024, VoxelType::Int64}, {1280, VoxelType::UInt64}};

/// Where the voxels are: the sform when it is set, else the qform, else the steps alone.
void read_place(const Header& h, VolumeInfo& info) {
  const Vec3 step(h.at<float>(76, 1), h.at<float>(76, 2), h.at<float>(76, 3));
  if (h.at<std::int16_t>(254) > 0) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        info.axes(r, c) = h.at<float>(280 + 16 * static_cast<std::size_t>(r), static_cast<std::size_t>(c));
      info.origin[r] = h.at<float>(280 + 16 * static_cast<std::size_t>(r), 3);
    }
    return;
  }
  info.axes = step.cwiseAbs().asDiagonal();
  if (h.at<std::int16_t>(252) <= 0) return;
  const double b = h.at<float>(256), c = h.at<float>(260), d = h.at<float>(264);
  const double a = std::sqrt(std::max(0.0, 1.0 - b * b - c * c - d * d));
  const double hand = h.at<float>(76) < 0.0f ? -1.0 : 1.0;  // qfac: the third axis may be turned round
  info.axes = Quat(a, b, c, d).normalized().toRotationMatrix() *
              Vec3(std::abs(step.x()), std::abs(step.y()), hand * std::abs(step.z())).asDiagonal();
  info.origin = Vec3(h.at<float>(268), h.at<float>(272), h.at<float>(276));
}

}  // namespace

VolumeInfo read_nifti_info(const std::string& path) {
  VolumeInfo info;
  info.path = info.data_path = path;
  info.format = "NIfTI-1";
  const bool gzip = is_gzip(path);
  Header h;
  ByteSource source(path, 0, gzip);
  if (const std::size_t got = source.read_some(h.bytes.data(), kHeaderBytes); got != kHeaderBytes)
    throw InputError(fmt::format("{}: {} bytes; a NIfTI-1 volume has at least {}", path, got, kHeaderBytes));
  if (h.at<std::int32_t>(0) != static_cast<std::int32_t>(kHeaderBytes)) h.swapped = true;
  if (h.at<std::int32_t>(0) != static_cast<std::int32_t>(kHeaderBytes) || h.bytes[344] != 'n')
    throw InputError(fmt::format("{}: is not a NIfTI-1 volume; its header must start with {} and end with \"n+1\"",
                                 path, kHeaderBytes));
  if (h.bytes[345] != '+')
    throw InputError(
        path + ": the voxels of this NIfTI-1 header are in another file (.hdr and .img); join them to one .nii file");
  const int axes = h.at<std::int16_t>(40);
  for (int a = 1; a <= std::clamp(axes, 0, 7); ++a) {
    const int n = h.at<std::int16_t>(40, static_cast<std::size_t>(a));
    if (a <= 3)
      info.size[a - 1] = n;
    else if (n > 1)
      throw InputError(fmt::format("{}: has {} values along axis {}; a volume has three axes", path, n, a));
  }
  for (int a = std::max(0, axes); a < 3; ++a) info.size[a] = axes < 1 || axes > 7 ? 0 : 1;
  const int type = h.at<std::int16_t>(70);
  const auto known = kNiftiTypes.find(type);
  if (known == kNiftiTypes.end())
    throw InputError(fmt::format("{}: voxels are of type {}; they must be whole numbers or floats", path, type));
  info.type = known->second;
  info.big_endian = h.swapped;
  const double slope = h.at<float>(112), intercept = h.at<float>(116);
  if (slope != 0.0 && std::isfinite(slope) && std::isfinite(intercept)) info.slope = slope, info.intercept = intercept;
  const int unit = h.bytes[123] & 7;
  info.unit_given = unit >= 1 && unit <= 3;
  info.unit = unit == 1 ? 1.0 : unit == 3 ? 1e-6 : 1e-3;
  read_place(h, info);
  const double offset = h.at<float>(108);
  if (!(offset >= kHeaderBytes && offset < 1e9))
    throw InputError(
        fmt::format("{}: voxels start at byte {}; must be after the header of {}", path, offset, kHeaderBytes));
  info.data_offset = static_cast<std::size_t>(offset);
  info.encoding = gzip ? VolumeInfo::Encoding::Gzip : VolumeInfo::Encoding::Plain;
  return info;
}

void write_nifti(const std::string& path, const VoxelImage& image) {
  Header h;
  h.put<std::int32_t>(0, static_cast<std::int32_t>(kHeaderBytes));
  h.put<std::int16_t>(40, 3);
  h.put<float>(76, 1.0f);
  for (std::size_t a = 0; a < 3; ++a) {
    h.put<std::int16_t>(42 + 2 * a, static_cast<std::int16_t>(image.size[static_cast<int>(a)]));
    h.put<float>(80 + 4 * a, static_cast<float>(1e3 * image.axes.col(static_cast<int>(a)).norm()));
    for (std::size_t c = 0; c < 3; ++c)
      h.put<float>(280 + 16 * a + 4 * c,
                   static_cast<float>(1e3 * image.axes(static_cast<int>(a), static_cast<int>(c))));
    h.put<float>(280 + 16 * a + 12, static_cast<float>(1e3 * image.origin[static_cast<int>(a)]));
  }
  for (std::size_t a = 3; a < 7; ++a) h.put<std::int16_t>(42 + 2 * a, 1);
  h.put<std::int16_t>(70, 16);
  h.put<std::int16_t>(72, 32);
  h.put<float>(108, 352.0f);
  h.put<float>(112, 1.0f);
  h.bytes[123] = 2;  // millimetres
  h.put<std::int16_t>(254, 1);
  std::memcpy(h.bytes.data() + 344, "n+1", 4);
  std::ofstream out(path, std::ios::binary);
  const char none[4] = {0, 0, 0, 0};
  out.write(h.bytes.data(), kHeaderBytes).write(none, 4);
  out.write(reinterpret_cast<const char*>(image.values.data()),
            static_cast<std::streamsize>(image.values.size() * sizeof(float)));
  if (!out.flush()) throw InputError(path + ": cannot be written");
}

}  // namespace brim
