#include "brim/record/folder_lock.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <optional>

#include "brim/core/error.h"

namespace brim::folder_lock_test {
namespace {

namespace fs = std::filesystem;

TEST(FolderLock, IsHeldByOneAtATimeAndLeavesNothingBehind) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("brim_lock_{}", ::getpid());
  fs::create_directories(folder);
  std::optional<FolderLock> first(std::in_place, folder.string());
  EXPECT_THROW(FolderLock(folder.string()), InputError);
  FolderLock moved(std::move(*first));
  first.reset();
  EXPECT_THROW(FolderLock(folder.string()), InputError) << "it moved, it did not end";
  moved = FolderLock();
  EXPECT_NO_THROW(FolderLock(folder.string()));
  EXPECT_TRUE(fs::is_empty(folder));
  fs::remove_all(folder);
  EXPECT_THROW(FolderLock(folder.string()), InputError);
}

}  // namespace
}  // namespace brim::folder_lock_test
