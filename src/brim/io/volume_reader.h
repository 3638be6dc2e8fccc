#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "brim/mesh/voxel_image.h"

namespace brim {

/// How a voxel is stored.
enum class VoxelType : std::uint8_t { UInt8, Int8, UInt16, Int16, UInt32, Int32, UInt64, Int64, Float32, Float64 };
std::size_t voxel_bytes(VoxelType type);
/// "uint8", "float32", ...
const char* voxel_word(VoxelType type);
/// @return nothing for a word that is no type
std::optional<VoxelType> voxel_type(const std::string& word);

/// Voxels of a format that is no plain array.
class SliceSource {
 public:
  virtual ~SliceSource() = default;
  /// Stored values of slice k, shape (size.y, size.x).
  virtual void read(int k, std::span<double> out) = 0;
};

/// What a volume file says of itself; the voxels are still to be read.
struct VolumeInfo {
  enum class Encoding : std::uint8_t { Plain, Gzip, Text, Slices };
  std::string path;            ///< as the user named it
  std::string format;          ///< "NIfTI-1", "NRRD", "OpenVDB, grid 'density'", "raw"
  Vec3i size = Vec3i::Zero();  ///< voxels, all positive
  VoxelType type = VoxelType::UInt8;
  bool big_endian = false;
  double slope = 1.0, intercept = 0.0;  ///< intensity = slope · stored + intercept
  double unit = 1e-3;                   ///< [m] of one unit of length of the file
  bool unit_given = false;              ///< the file says so; otherwise millimetres are taken
  Mat3 axes = Mat3::Identity();  ///< [file units] to x right, y front, z up of the patient where the file says so
  Vec3 origin = Vec3::Zero();    ///< [file units] centre of the first voxel
  std::string data_path;         ///< file that holds the voxels
  std::size_t file_offset = 0;   ///< where the (packed) voxels start in it
  std::size_t data_offset = 0;   ///< bytes to skip after unpacking
  Encoding encoding = Encoding::Plain;
  std::shared_ptr<SliceSource> slices;  ///< where the encoding is Slices

  double count() const { return static_cast<double>(size.x()) * size.y() * size.z(); }
  /// [m] steps along i, j, k.
  Vec3 steps() const { return unit * axes.colwise().norm().transpose(); }
};

/// What a file without a header cannot say.
struct RawLayout {
  Vec3i size = Vec3i::Zero();
  Vec3 spacing = Vec3::Ones();  ///< [m] between voxels along i, j, k
  VoxelType type = VoxelType::UInt8;
  bool big_endian = false;
  std::size_t skip = 0;  ///< bytes before the first voxel
};

/// Reads the header of a NIfTI-1 (.nii, .nii.gz; both byte orders, scaling, sform or qform), NRRD (.nrrd, .nhdr; raw,
/// gzip, text; spacings or space directions) or OpenVDB file (.vdb, in metres: the grid called density, or the first of
/// numbers, in the box of its active voxels; of level sets the intensity is minus the distance), of a series of DICOM
/// images (a folder, with those below it, or a file of the series: that series in the file's folder), or makes up that
/// of a raw file.
/// @param grid  name of the grid to take of an OpenVDB file; empty: as above
/// @param series  of DICOM: its UID, or "largest" for that with most voxels; empty: of a file its own, of a folder the
///   only one that has more than one slice
/// @throws InputError  for files of another kind, with sizes that are not positive, steps that are zero or not finite,
///   axes in one plane, more than three axes, colours, voxels of no known type, or fewer bytes than voxels; for DICOM
///   series that are no even stack of parallel slices (slice_stack.h), and folders of several series, which it lists
/// Tests: tests/io/volume_reader_test.cpp, tests/io/dicom_test.cpp
VolumeInfo read_volume_info(const std::string& path, const std::string& grid = {}, const std::string& series = {});
/// Whether a path is that of a DICOM file, or of a folder that holds one, by the letters DICM at byte 128.
bool holds_dicom(const std::string& path);
VolumeInfo raw_volume_info(const std::string& path, const RawLayout& layout);

struct VolumeReadOptions {
  Vec3i coarsen = Vec3i::Ones();           ///< blocks of so many voxels become one, their mean
  std::function<double(double)> transfer;  ///< of intensities, before the mean; empty: none
  double max_bytes = 8e9;                  ///< most memory for the image
};

/// Reads the voxels, slice by slice: memory holds the result and a slice. Voxels that are not a number count as zero.
/// @throws InputError  when the data are cut short or broken, or the image would pass max_bytes
VoxelImage read_volume(const VolumeInfo& info, const VolumeReadOptions& options = {});

/// Writes an image as NIfTI-1, float32, little-endian, in millimetres with its axes as sform; for tools and tests.
/// @throws InputError  when the file cannot be written
void write_nifti(const std::string& path, const VoxelImage& image);

}  // namespace brim
