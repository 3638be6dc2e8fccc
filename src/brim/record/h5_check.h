#pragma once

#include <string>

namespace brim::h5 {

/// Rejects files that crash HDF5: a separate process with limits of memory and time (ChildReader) first reads all
/// metadata of groups and data sets, and small data sets as a whole. HDF5 1.10 divides by chunk lengths of zero,
/// follows cycles and reads beyond the end of damaged files: more cases than can be checked beforehand. Errors that
/// HDF5 reports there do not reject the file: only the requested data must be good. Takes about 15 ms of processor
/// time.
/// @throws InputError  when that process died
/// Tests: tests/record/h5_check_test.cpp
void need_sound(const std::string& path);

}  // namespace brim::h5
