#pragma once

#include "brim/io/volume_reader.h"

namespace brim {

/// Header readers, one per format. The caller checks sizes and axes.
VolumeInfo read_nifti_info(const std::string& path);
VolumeInfo read_nrrd_info(const std::string& path);
/// @param grid  name of the grid to read; empty: "density", or the first numeric grid
VolumeInfo read_vdb_info(const std::string& path, const std::string& grid);
/// @param series  UID of the series to read, or "largest"; empty: that of the file, or the only one of the folder
VolumeInfo read_dicom_info(const std::string& path, const std::string& series);

}  // namespace brim
