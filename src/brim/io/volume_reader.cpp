#include "brim/io/volume_reader.h"

#include <Eigen/LU>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>
#include <set>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/io/byte_source.h"
#include "brim/io/regular_file.h"
#include "brim/io/volume_formats.h"

namespace brim {

namespace {

struct TypeWord {
  const char* word;
  std::size_t bytes;
};
constexpr TypeWord kTypeWords[] = {{"uint8", 1}, {"int8", 1},   {"uint16", 2}, {"int16", 2},   {"uint32", 4},
                                   {"int32", 4}, {"uint64", 8}, {"int64", 8},  {"float32", 4}, {"float64", 8}};

/// What the formats cannot say: sizes and axes.
void check_geometry(const VolumeInfo& info) {
  if (static_cast<std::size_t>(info.type) >= std::size(kTypeWords))
    throw InputError(info.path + ": the file is damaged: its numbers are of no known type");
  if ((info.size.array() < 1).any())
    throw InputError(fmt::format("{}: the size {} x {} x {} is not allowed; all three must be at least 1", info.path,
                                 info.size.x(), info.size.y(), info.size.z()));
  if (!(info.count() < 1e12))
    throw InputError(fmt::format("{}: {:.3g} voxels are not allowed; must be below 1e12", info.path, info.count()));
  const Vec3 steps = info.axes.colwise().norm();
  if (!info.axes.allFinite() || !(steps.minCoeff() > 0.0) || !info.origin.allFinite())
    throw InputError(
        fmt::format("{}: voxel steps of {:.6g}, {:.6g}, {:.6g} are not allowed; all must be positive and finite",
                    info.path, steps.x(), steps.y(), steps.z()));
  if (!(std::abs(info.axes.determinant()) > 1e-6 * steps.prod()))
    throw InputError(info.path + ": the axes of the volume lie in one plane");
}

/// Bytes of a file of plain voxels with what stands before them.
double bytes_needed(const VolumeInfo& info) {
  return static_cast<double>(info.file_offset) + static_cast<double>(info.data_offset) +
         info.count() * static_cast<double>(voxel_bytes(info.type));
}

/// That the bytes are there.
void check_length(const VolumeInfo& info) {
  need_regular_file(info.data_path);
  const std::size_t size = file_size(info.data_path);
  const double needed = bytes_needed(info);
  if (info.encoding == VolumeInfo::Encoding::Plain && static_cast<double>(size) < needed)
    throw InputError(fmt::format("{}: the file is cut short: {} bytes are there where {:.0f} are needed",
                                 info.data_path, size, needed));
}

template <class T>
void convert(const char* raw, std::size_t n, bool swapped, double* out) {
  for (std::size_t i = 0; i < n; ++i) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, raw + i * sizeof(T), sizeof(T));
    if (swapped) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    out[i] = static_cast<double>(value);
  }
}

void convert(VoxelType type, const char* raw, std::size_t n, bool swapped, double* out) {
  switch (type) {
    case VoxelType::UInt8:
      return convert<std::uint8_t>(raw, n, swapped, out);
    case VoxelType::Int8:
      return convert<std::int8_t>(raw, n, swapped, out);
    case VoxelType::UInt16:
      return convert<std::uint16_t>(raw, n, swapped, out);
    case VoxelType::Int16:
      return convert<std::int16_t>(raw, n, swapped, out);
    case VoxelType::UInt32:
      return convert<std::uint32_t>(raw, n, swapped, out);
    case VoxelType::Int32:
      return convert<std::int32_t>(raw, n, swapped, out);
    case VoxelType::UInt64:
      return convert<std::uint64_t>(raw, n, swapped, out);
    case VoxelType::Int64:
      return convert<std::int64_t>(raw, n, swapped, out);
    case VoxelType::Float32:
      return convert<float>(raw, n, swapped, out);
    case VoxelType::Float64:
      return convert<double>(raw, n, swapped, out);
  }
}

/// Numbers of a text, separated by anything that is no part of one.
class TextNumbers {
 public:
  TextNumbers(const std::string& path, ByteSource& source) : path_(path), source_(source), buffer_(1u << 16) {}
  void read(std::size_t n, double* out) {
    for (std::size_t i = 0; i < n; ++i) out[i] = next();
  }

 private:
  int peek() {
    if (at_ == end_) {
      at_ = 0;
      end_ = source_.read_some(buffer_.data(), buffer_.size());
    }
    return at_ < end_ ? static_cast<unsigned char>(buffer_[at_]) : -1;
  }
  double next() {
    while (peek() == ',' || std::isspace(peek()) != 0) ++at_;
    std::string word;
    for (int c; (c = peek()) >= 0 && c != ',' && std::isspace(c) == 0 && word.size() < 64; ++at_)
      word += static_cast<char>(c);
    if (word.empty()) throw InputError(path_ + ": the file is cut short: fewer numbers than voxels");
    char* end = nullptr;
    const double x = std::strtod(word.c_str(), &end);
    if (*end != '\0') throw InputError(fmt::format("{}: \"{}\" is not a number", path_, word));
    return x;
  }
  const std::string& path_;
  ByteSource& source_;
  std::vector<char> buffer_;
  std::size_t at_ = 0, end_ = 0;
};

/// Largest magnitude of an intensity: infinite ones become this.
constexpr double kLargest = 1e30;

double intensity_of(const VolumeInfo& info, double stored) {
  return std::clamp(info.slope * stored + info.intercept, -kLargest, kLargest);
}

/// Gives voxels without a number the lowest intensity of all: that of air in scans.
void fill_unmeasured(std::vector<float>& values) {
  float lowest = std::numeric_limits<float>::infinity();
  for (const float v : values)
    if (v < lowest) lowest = v;
  for (float& v : values)
    if (std::isnan(v)) v = lowest;
}

/// Calls f(k) for each slice, in order, with the stored values in `value`, shape (size.y, size.x).
template <class F>
void each_slice(const VolumeInfo& info, std::vector<double>& value, const F& f) {
  const bool text_of_numbers = info.encoding == VolumeInfo::Encoding::Text;
  std::optional<ByteSource> source;
  std::optional<TextNumbers> text;
  if (!info.slices) {
    source.emplace(info.data_path, info.file_offset, info.encoding == VolumeInfo::Encoding::Gzip);
    source->skip(info.data_offset);
    text.emplace(info.data_path, *source);
  }
  const std::size_t nx = static_cast<std::size_t>(info.size.x()), ny = static_cast<std::size_t>(info.size.y());
  const std::size_t slice = nx * ny, width = voxel_bytes(info.type);
  std::vector<char> raw(text_of_numbers || info.slices ? 0 : slice * width);
  value.resize(slice);
  for (int k = 0; k < info.size.z(); ++k) {
    if (info.slices) {
      info.slices->read(k, value);
    } else if (text_of_numbers) {
      text->read(slice, value.data());
    } else {
      source->read(raw.data(), raw.size());
      parallel_for(
          ny,
          [&](std::size_t j) {
            convert(info.type, raw.data() + j * nx * width, nx, info.big_endian, value.data() + j * nx);
          },
          32);
    }
    f(k);
  }
}

std::string lower_case(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

}  // namespace

std::size_t voxel_bytes(VoxelType type) { return kTypeWords[static_cast<int>(type)].bytes; }
const char* voxel_word(VoxelType type) { return kTypeWords[static_cast<int>(type)].word; }
std::optional<VoxelType> voxel_type(const std::string& word) {
  for (std::size_t i = 0; i < std::size(kTypeWords); ++i)
    if (word == kTypeWords[i].word) return static_cast<VoxelType>(i);
  return std::nullopt;
}

VolumeInfo read_volume_info(const std::string& path, const std::string& grid, const std::string& series) {
  const std::string name = lower_case(path);
  std::error_code error;
  const bool folder = std::filesystem::is_directory(path, error);
  if (!folder) need_regular_file(path);
  VolumeInfo info;
  bool dicom = false;
  if (name.ends_with(".nii") || name.ends_with(".nii.gz"))
    info = read_nifti_info(path);
  else if (name.ends_with(".nrrd") || name.ends_with(".nhdr"))
    info = read_nrrd_info(path);
  else if (name.ends_with(".vdb"))
    info = read_vdb_info(path, grid);
  else if ((dicom = holds_dicom(path)))
    info = read_dicom_info(path, series);
  else if (folder)
    throw InputError(path + ": a folder without DICOM files (with DICM at byte 128); no volume");
  else
    throw InputError(path +
                     ": not a volume that brim reads; it must end in .nii, .nii.gz, .nrrd, .nhdr or .vdb, or be a "
                     "DICOM file or folder");
  if (!grid.empty() && !name.ends_with(".vdb"))
    throw InputError(fmt::format("{}: a grid ('{}') can be chosen of .vdb files only", path, grid));
  if (!series.empty() && !dicom)
    throw InputError(fmt::format("{}: a series ('{}') can be chosen of DICOM files only", path, series));
  check_geometry(info);
  check_length(info);
  return info;
}

VolumeInfo raw_volume_info(const std::string& path, const RawLayout& layout) {
  const std::string name = lower_case(path);
  for (const char* end : {".nii", ".nii.gz", ".nrrd", ".nhdr", ".vdb"})
    if (name.ends_with(end))
      throw InputError(fmt::format(
          "{}: a \"raw\" layout is for files without a header, and a {} file has one; leave \"raw\" out", path, end));
  if (holds_dicom(path))
    throw InputError(path + ": a \"raw\" layout is for files without a header, and DICOM has one; leave \"raw\" out");
  VolumeInfo info;
  info.path = info.data_path = path;
  info.format = "raw";
  info.size = layout.size;
  info.type = layout.type;
  info.big_endian = layout.big_endian;
  info.unit = 1.0;
  info.unit_given = true;
  info.axes = layout.spacing.asDiagonal();
  info.data_offset = layout.skip;
  check_geometry(info);
  need_regular_file(path);
  const std::size_t size = file_size(path);
  if (static_cast<double>(size) != bytes_needed(info))
    throw InputError(fmt::format(
        "{}: the file has {} bytes, and the layout needs {:.0f}: {} to skip, and {} x {} x {} voxels of {}", path, size,
        bytes_needed(info), layout.skip, info.size.x(), info.size.y(), info.size.z(), voxel_word(info.type)));
  return info;
}

VoxelImage read_volume(const VolumeInfo& info, const VolumeReadOptions& options) {
  const Vec3i c = options.coarsen.cwiseMax(1).cwiseMin(info.size);
  VoxelImage image;
  image.size = ((info.size.array() + c.array() - 1) / c.array()).matrix();
  const double bytes = sizeof(float) * static_cast<double>(image.size.x()) * image.size.y() * image.size.z();
  if (bytes > options.max_bytes)
    throw InputError(fmt::format("{}: {} x {} x {} voxels would take {:.3g} bytes; memory_limit allows {:.3g}",
                                 info.path, image.size.x(), image.size.y(), image.size.z(), bytes, options.max_bytes));
  const Vec3 cd = c.cast<double>();
  image.axes = info.unit * info.axes * cd.asDiagonal();
  image.origin = info.unit * (info.origin + info.axes * (0.5 * (cd - Vec3::Ones())));
  image.values.assign(image.count(), 0.0f);

  const std::size_t nx = static_cast<std::size_t>(info.size.x()), ny = static_cast<std::size_t>(info.size.y());
  std::vector<double> value, sum(static_cast<std::size_t>(image.size.x()) * image.size.y(), 0.0);
  std::vector<double> count(sum.size(), 0.0);
  std::vector<char> finite(static_cast<std::size_t>(image.size.y()), 0);  // rows that hold a finite intensity
  each_slice(info, value, [&](int k) {
    // Rows of one coarse row belong together, so that no two threads write to it.
    parallel_for(
        static_cast<std::size_t>(image.size.y()),
        [&](std::size_t row) {
          const std::size_t first = row * c.y(), last = std::min(ny, first + c.y());
          for (std::size_t j = first; j < last; ++j)
            for (std::size_t i = 0; i < nx; ++i) {
              double v = intensity_of(info, value[j * nx + i]);
              if (std::isnan(v)) continue;  // nothing was measured: no matter
              if (std::abs(v) < kLargest) finite[row] = 1;
              if (options.transfer) v = options.transfer(v);
              const std::size_t at =
                  row * static_cast<std::size_t>(image.size.x()) + i / static_cast<std::size_t>(c.x());
              sum[at] += v;
              count[at] += 1.0;
            }
        },
        16);
    if ((k + 1) % c.z() == 0 || k + 1 == info.size.z()) {
      float* out = image.values.data() + sum.size() * static_cast<std::size_t>(k / c.z());
      // Beyond the border there is no matter, so shares are means over whole blocks.
      const double whole = c.prod();
      for (std::size_t i = 0; i < sum.size(); ++i)
        out[i] = static_cast<float>(sum[i] / (options.transfer ? whole : count[i]));
      std::fill(sum.begin(), sum.end(), 0.0);
      std::fill(count.begin(), count.end(), 0.0);
    }
  });
  if (std::find(finite.begin(), finite.end(), 1) == finite.end())
    throw InputError(info.path + ": no voxel has a finite intensity; all are not-a-number or infinite");
  fill_unmeasured(image.values);
  return image;
}

IntensitySummary summarize_intensities(const VolumeInfo& info, const std::function<double(double)>& share) {
  IntensitySummary s;
  std::set<int> labels;
  std::vector<double> value;
  each_slice(info, value, [&](int) {
    for (const double stored : value) {
      const double v = intensity_of(info, stored);
      if (std::isnan(v)) continue;
      s.least = std::min(s.least, v);
      s.most = std::max(s.most, v);
      s.fullest = std::max(s.fullest, share(v));
      if (std::abs(v) > 1e9) continue;
      labels.insert(static_cast<int>(std::lround(v)));
      if (labels.size() <= IntensitySummary::kMostLabels) continue;
      labels.erase(std::prev(labels.end()));
      s.more_labels = true;
    }
  });
  s.labels.assign(labels.begin(), labels.end());
  return s;
}

}  // namespace brim
