#pragma once

#include <string>

namespace brim::cli {

/// What the header of a NIfTI-1 volume says (nifti1.h of the NIfTI-1.1 standard), in either byte order, in words.
/// @throws InputError  when the file is too short or no NIfTI-1
std::string nifti_text(const std::string& path);

}  // namespace brim::cli
