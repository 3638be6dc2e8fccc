#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "brim/mesh/voxel_image.h"

namespace brim {

/// Storage type of a voxel.
enum class VoxelType : std::uint8_t { UInt8, Int8, UInt16, Int16, UInt32, Int32, UInt64, Int64, Float32, Float64 };
std::size_t voxel_bytes(VoxelType type);
/// "uint8", "float32", ...
const char* voxel_word(VoxelType type);
/// @return nothing for an unknown type
std::optional<VoxelType> voxel_type(const std::string& word);

/// Voxels of a format that is not a plain array.
class SliceSource {
 public:
  virtual ~SliceSource() = default;
  /// Stored values of slice k, shape (size.y, size.x).
  virtual void read(int k, std::span<double> out) = 0;
};

/// Header of a volume file; the voxels are not read yet.
struct VolumeInfo {
  enum class Encoding : std::uint8_t { Plain, Gzip, Text, Slices };
  std::string path;            ///< as given by the user
  std::string format;          ///< "NIfTI-1", "NRRD", "OpenVDB, grid 'density'", "raw"
  Vec3i size = Vec3i::Zero();  ///< voxels, all positive
  VoxelType type = VoxelType::UInt8;
  bool big_endian = false;
  double slope = 1.0, intercept = 0.0;  ///< intensity = slope · stored + intercept
  double unit = 1e-3;                   ///< [m] length unit of the file
  bool unit_given = false;              ///< given by the file; otherwise millimetres are assumed
  Mat3 axes = Mat3::Identity();  ///< [file units] to the patient's x right, y front, z up, if the file defines them
  Vec3 origin = Vec3::Zero();    ///< [file units] centre of the first voxel
  std::string data_path;         ///< file that contains the voxels
  std::size_t file_offset = 0;   ///< offset of the (compressed) voxels in it
  std::size_t data_offset = 0;   ///< bytes to skip after unpacking
  Encoding encoding = Encoding::Plain;
  std::shared_ptr<SliceSource> slices;  ///< if the encoding is Slices

  double count() const { return static_cast<double>(size.x()) * size.y() * size.z(); }
  /// [m] steps along i, j, k.
  Vec3 steps() const { return unit * axes.colwise().norm().transpose(); }
};

/// Layout of a raw file, which has no header.
struct RawLayout {
  Vec3i size = Vec3i::Zero();
  Vec3 spacing = Vec3::Ones();  ///< [m] between voxels along i, j, k
  VoxelType type = VoxelType::UInt8;
  bool big_endian = false;
  std::size_t skip = 0;  ///< bytes before the first voxel
};

/// Reads the header of a volume: NIfTI-1 (.nii, .nii.gz; both byte orders, scaling, sform or qform), NRRD (.nrrd,
/// .nhdr; raw, gzip, text; spacings or space directions), OpenVDB (.vdb, in metres: the grid "density", or the first
/// numeric one, in the box of its active voxels; for level sets the intensity is minus the distance), DICOM (a folder
/// with its subfolders, or a file: its series in the file's folder).
/// @param grid  name of the grid of an OpenVDB file; empty: as above
/// @param series  DICOM: UID, or "largest" for the one with most voxels; empty: for a file its own, for a folder the
///                only one with more than one slice
/// @throws InputError  for other formats, sizes that are not positive, steps that are zero or not finite, coplanar
///                     axes, more than three axes, colours, unknown voxel types, or fewer bytes than voxels; for DICOM
///                     series that are no even stack of parallel slices (slice_stack.h), and folders of several series,
///                     which it lists
/// Tests: tests/io/volume_reader_test.cpp, tests/io/dicom_test.cpp
VolumeInfo read_volume_info(const std::string& path, const std::string& grid = {}, const std::string& series = {});
/// True for a DICOM file, or a folder that contains one, by the letters DICM at byte 128.
bool holds_dicom(const std::string& path);
/// @throws InputError  likewise, when the file's size is not that of the layout, and for files of the formats above
VolumeInfo raw_volume_info(const std::string& path, const RawLayout& layout);

struct VolumeReadOptions {
  Vec3i coarsen = Vec3i::Ones();           ///< block size in voxels; each block is replaced by its mean
  std::function<double(double)> transfer;  ///< applied to intensities before the mean; empty: none
  double max_bytes = 8e9;                  ///< memory limit for the image
};

/// Reads the voxels slice by slice: memory holds the result and one slice. NaN counts as zero.
/// @throws InputError  when the data are truncated or corrupt, no intensity is finite, or the image would exceed
///                     max_bytes
VoxelImage read_volume(const VolumeInfo& info, const VolumeReadOptions& options = {});

/// Intensities of a volume, for messages.
struct IntensitySummary {
  static constexpr std::size_t kMostLabels = 20;
  double least = std::numeric_limits<double>::infinity(), most = -least;  ///< without NaN; infinite ones count as 1e30
  double fullest = 0.0;                                                   ///< largest share of matter of a voxel
  std::vector<int> labels;   ///< lowest distinct values, rounded, ascending; at most kMostLabels
  bool more_labels = false;  ///< there are others
};

/// Reads the voxels once more, slice by slice. @param share  of matter by intensity
IntensitySummary summarize_intensities(const VolumeInfo& info, const std::function<double(double)>& share);

/// Writes an image as NIfTI-1, float32, little-endian, in millimetres with its axes as sform; for tools and tests.
/// @throws InputError  when the file cannot be written
void write_nifti(const std::string& path, const VoxelImage& image);

}  // namespace brim
