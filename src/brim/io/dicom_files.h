#pragma once

#include <string>
#include <vector>

#include "brim/io/child_reader.h"

namespace brim {

/// Files that begin as DICOM files do: DICM after 128 bytes of anything.
struct DicomFiles {
  std::vector<std::string> paths;  ///< sorted
  ChildReader::Load load;          ///< to read them
};

bool is_dicom_file(const std::string& path);

/// Those of a folder and of the folders below it (links to folders are not followed).
/// @param deep  false: of the folder alone
/// @throws InputError  when it has more than 200 000 entries
DicomFiles find_dicom_files(const std::string& folder, bool deep);

}  // namespace brim
