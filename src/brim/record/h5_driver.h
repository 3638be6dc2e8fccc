#pragma once

#include <cstdint>

namespace brim::h5 {

/// HDF5's identifier (hid_t) of the way in which run files reach the disk: raw data at once, metadata together at each
/// flush through a Journal. Whenever the process is killed, the file is that of its last whole flush.
/// HDF5 alone writes metadata place by place: a process killed within a flush left data sets that could not be opened.
/// Local heaps that HDF5 would follow without end are refused in files that are only read (local_heap.h).
/// @return negative when HDF5 refuses it
std::int64_t journal_driver();

}  // namespace brim::h5
