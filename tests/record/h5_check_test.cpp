#include "brim/record/h5_check.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "brim/core/error.h"
#include "brim/record/h5.h"
#include "checkout_paths.h"

namespace brim::h5::h5_check_test {
namespace {

namespace fs = std::filesystem;

std::string kept(const char* name) { return (fs::path(BRIM_SOURCE_DIR) / "tests/fuzz/inputs/run" / name).string(); }

/// HDF5 1.10 divides by the length of its chunks.
TEST(H5Check, AFileThatEndsTheLibraryIsRefusedAndThisProcessGoesOn) {
  try {
    File(kept("chunk_of_no_rows.h5"), File::Mode::Read);
    ADD_FAILURE() << "was opened";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("the file is damaged"), std::string::npos) << error.what();
  }
}

TEST(H5Check, WholeFilesAndThoseThatTheLibraryRefusesArePassedOn) {
  need_sound(kept("small.h5"));
  need_sound(kept("endless_heap.h5"));  // refused by what opens it, with its own words
  EXPECT_FALSE(File(kept("small.h5"), File::Mode::Read).datasets().empty());
}

}  // namespace
}  // namespace brim::h5::h5_check_test
