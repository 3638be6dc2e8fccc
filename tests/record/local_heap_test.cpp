#include "brim/record/local_heap.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "brim/core/error.h"
#include "brim/record/h5.h"
#include "checkout_paths.h"

namespace brim::h5::local_heap_test {
namespace {

namespace fs = std::filesystem;

/// A file of a superblock, and from byte 64 the head and the data of a local heap, by the layout of local_heap.h.
struct HeapFile {
  static constexpr std::uint64_t kHead = 64, kData = 128, kSize = 64;
  std::vector<std::byte> bytes = std::vector<std::byte>(kData + kSize);

  explicit HeapFile(std::uint64_t first_free) {
    const char start[] = "\x89HDF\r\n\x1a\n\0\0\0\0\0\x08\x08";
    std::memcpy(bytes.data(), start, sizeof start);
    std::memcpy(bytes.data() + kHead, "HEAP", 4);
    put(kHead + 8, kSize);
    put(kHead + 16, first_free);
    put(kHead + 24, kData);
  }
  void put(std::uint64_t at, std::uint64_t number) { std::memcpy(bytes.data() + at, &number, sizeof number); }
  void put_free(std::uint64_t block, std::uint64_t next) { put(kData + block, next); }
  bool ends() const {
    return local_heap_ends(std::span(bytes).subspan(kHead), bytes.size(),
                           [&](std::uint64_t at, std::span<std::byte> to) {
                             if (at + to.size() > bytes.size()) return false;
                             std::memcpy(to.data(), bytes.data() + at, to.size());
                             return true;
                           });
  }
};

TEST(LocalHeap, ListsThatEndAreTaken) {
  EXPECT_TRUE(HeapFile(1).ends());
  HeapFile two(32);
  two.put_free(32, 0);
  two.put_free(0, 1);
  EXPECT_TRUE(two.ends());
}

TEST(LocalHeap, RingsAndBlocksOutsideAreRefused) {
  HeapFile itself(16);
  itself.put_free(16, 16);
  EXPECT_FALSE(itself.ends());
  HeapFile ring(0);
  ring.put_free(0, 32);
  ring.put_free(32, 0);
  EXPECT_FALSE(ring.ends());
  EXPECT_FALSE(HeapFile(56).ends()) << "the second number of the block is beyond the data";
  EXPECT_FALSE(HeapFile(std::uint64_t(-1)).ends());
  HeapFile beyond(0);
  beyond.put_free(0, 1);
  beyond.put(HeapFile::kHead + 8, 1 << 30);
  EXPECT_FALSE(beyond.ends()) << "data that the file has not";
}

TEST(LocalHeap, NumbersOfOtherWidthsAreRefused) {
  HeapFile narrow(1);
  narrow.bytes[13] = std::byte{4};
  EXPECT_FALSE(narrow.ends());
}

/// HDF5 1.10 took memory without end while it listed the links of this file.
TEST(LocalHeap, ARunWithARingOfFreeRoomIsRefusedInOneLine) {
  const fs::path damaged = fs::path(BRIM_SOURCE_DIR) / "tests/fuzz/inputs/run/endless_heap.h5";
  const fs::path path = fs::path(::testing::TempDir()) / "endless_heap.h5";
  fs::copy_file(damaged, path, fs::copy_options::overwrite_existing);
  EXPECT_THROW(File(path.string(), File::Mode::Read).datasets(), InputError);
  EXPECT_THROW(File(path.string(), File::Mode::Write), InputError);
  EXPECT_FALSE(File(path.string(), File::Mode::Read).exists("/bodies/0/vertices"));
  fs::remove(path);
}

}  // namespace
}  // namespace brim::h5::local_heap_test
