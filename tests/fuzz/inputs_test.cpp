#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "checkout_paths.h"
#include "fuzz/file_targets.h"

namespace brim::inputs_test {
namespace {

namespace fs = std::filesystem;

class FuzzInputs : public ::testing::TestWithParam<fuzz::FileTarget> {};

/// Seeds of the fuzzer, and what it or others found: tests/fuzz/inputs/<target>.
TEST_P(FuzzInputs, AreReadOrRefusedWhole) {
  const fs::path folder = fs::path(BRIM_SOURCE_DIR) / "tests/fuzz/inputs" / GetParam().name;
  ASSERT_TRUE(fs::is_directory(folder)) << folder;
  int count = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path().string());
    std::ifstream in(entry.path(), std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    const fuzz::Bytes input(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    EXPECT_NO_THROW(static_cast<void>(GetParam().read(input)));
    ++count;
  }
  EXPECT_GT(count, 0) << "a target without an input is blind";
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzInputs, ::testing::ValuesIn(fuzz::kFileTargets),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace brim::inputs_test
