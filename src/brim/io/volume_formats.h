#pragma once

#include "brim/io/volume_reader.h"

namespace brim {

/// Headers, one format a file. Sizes and axes are checked by the caller.
VolumeInfo read_nifti_info(const std::string& path);
VolumeInfo read_nrrd_info(const std::string& path);
/// @param grid  name of the grid to take; empty: "density", or the first of numbers
VolumeInfo read_vdb_info(const std::string& path, const std::string& grid);
/// @param series  UID of the series to take, or "largest"; empty: that of the file, or the only one of the folder
VolumeInfo read_dicom_info(const std::string& path, const std::string& series);

}  // namespace brim
