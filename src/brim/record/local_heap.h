#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace brim::h5 {

/// Reads bytes of a file at an offset into all of `to`; bytes beyond its end are zero. @return false on failure
using ReadAt = std::function<bool(std::uint64_t at, std::span<std::byte> to)>;

/// True when the local heap (the names of an old-style group) with the header `head` is safe for HDF5.
///
///   head      "HEAP" | version | 3 x 0 | size of its data | first free block | address of its data
///   free      |next free block, 1: none|size of this one|  within the data
///
/// HDF5 1.10 follows the list of free blocks without limit: a cyclic list exhausts memory. Here blocks must lie within
/// the data, the data within the file, and there must be no more blocks than fit. (HDF5 File Format Specification 3.0,
/// III.D; sizes and addresses of 8 bytes, as HDF5 writes them.)
/// @param length  [bytes] of the file
/// Tests: tests/record/local_heap_test.cpp
bool local_heap_ends(std::span<const std::byte> head, std::uint64_t length, const ReadAt& read);

}  // namespace brim::h5
