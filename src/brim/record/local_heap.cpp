#include "brim/record/local_heap.h"

#include <cstring>
#include <vector>

namespace brim::h5 {

namespace {

constexpr std::size_t kHead = 32;       // [bytes]
constexpr std::size_t kFreeBlock = 16;  // [bytes] of its own two numbers
constexpr std::uint64_t kNoMore = 1;

std::uint64_t number_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 8; i-- > 0;) value = value << 8 | std::to_integer<std::uint64_t>(bytes[at + i]);
  return value;
}

/// Sizes and addresses of 8 bytes each, by the superblock (versions 0 to 3) at the beginning of the file.
bool has_wide_numbers(const ReadAt& read) {
  std::byte start[16];
  if (!read(0, start) || std::memcmp(start, "\x89HDF\r\n\x1a\n", 8) != 0) return false;
  const std::size_t sizes = start[8] < std::byte{2} ? 13 : 9;
  return start[sizes] == std::byte{8} && start[sizes + 1] == std::byte{8};
}

}  // namespace

bool local_heap_ends(std::span<const std::byte> head, std::uint64_t length, const ReadAt& read) {
  if (head.size() < kHead || !has_wide_numbers(read)) return false;
  const std::uint64_t size = number_at(head, 8), address = number_at(head, 24);
  std::uint64_t block = number_at(head, 16);
  if (block == kNoMore) return true;
  if (size > length || address > length - size || size < kFreeBlock) return false;
  std::vector<std::byte> data(size);
  if (!read(address, data)) return false;
  for (std::uint64_t left = size / kFreeBlock; block != kNoMore; --left) {
    if (left == 0 || block > size - kFreeBlock) return false;
    block = number_at(data, block);
  }
  return true;
}

}  // namespace brim::h5
