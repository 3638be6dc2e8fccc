#pragma once

#include <string>

namespace brim::h5 {

/// Refuses files that end HDF5: all that a file says of its groups and data sets is read first by a process of its own,
/// with limits of memory and time (ChildReader), and small data sets whole. HDF5 1.10 divides by a chunk's length of
/// zero, follows rings and reads beyond what damaged files hold: more than can be looked for beforehand. What HDF5
/// refuses there is no reason to refuse the file: only what is asked for need be good. It takes about 15 ms of
/// processor time.
/// @throws InputError  when that process ended
/// Tests: tests/record/h5_check_test.cpp
void need_sound(const std::string& path);

}  // namespace brim::h5
