#pragma once

#include <cstdint>

namespace brim::h5 {

/// HDF5 file driver (hid_t) of run files: raw data are written at once, metadata together at each flush through a
/// Journal. Whenever the process is killed, the file is that of its last complete flush. HDF5 alone writes metadata
/// piece by piece: a process killed within a flush left data sets that could not be opened. In files opened for
/// reading, local heaps with endless lists are rejected (local_heap.h).
/// @return negative on an HDF5 error
std::int64_t journal_driver();

}  // namespace brim::h5
