#pragma once

#include <string>
#include <vector>

#include "brim/io/child_reader.h"

namespace brim {

/// Files that look like DICOM: "DICM" after a preamble of 128 bytes.
struct DicomFiles {
  std::vector<std::string> paths;  ///< sorted
  ChildReader::Load load;          ///< to read them
};

bool is_dicom_file(const std::string& path);

/// Finds those in a folder and its subfolders (links to folders are not followed).
/// @param deep  false: without subfolders
/// @throws InputError  when it has more than 200 000 entries
DicomFiles find_dicom_files(const std::string& folder, bool deep);

}  // namespace brim
