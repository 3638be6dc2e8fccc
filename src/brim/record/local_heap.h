#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace brim::h5 {

/// Reads bytes of a file at a place into all of `to`; what lies beyond its end is zero. @return false when it cannot
using ReadAt = std::function<bool(std::uint64_t at, std::span<std::byte> to)>;

/// Whether HDF5 can be given the local heap (the names of an old-style group) whose head begins with `head`.
///
///   head      "HEAP" | version | 3 x 0 | size of its data | first free block | address of its data
///   free      |next free block, 1: none|size of this one|  within the data
///
/// HDF5 1.10 follows the list of free blocks without counting: one that leads back into itself takes memory until
/// there is none. Here blocks must lie within the data, which lie within the file, and be no more than there is room
/// for. (HDF5 File Format Specification 3.0, III.D; sizes and addresses of 8 bytes, as HDF5 writes them.)
/// @param length  [bytes] of the file
/// Tests: tests/record/local_heap_test.cpp
bool local_heap_ends(std::span<const std::byte> head, std::uint64_t length, const ReadAt& read);

}  // namespace brim::h5
