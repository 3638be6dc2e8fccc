#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

namespace brim::test {

/// A folder of its own for one test, removed at the end.
struct TemporaryFolder {
  std::filesystem::path path;

  TemporaryFolder() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    path = std::filesystem::temp_directory_path() / (std::string("brim_") + info->test_suite_name() + "_" +
                                                     info->name() + "_" + std::to_string(std::random_device{}()));
    std::filesystem::create_directories(path);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream file(path / name, std::ios::binary);
    file << content;
    return path / name;
  }
};

}  // namespace brim::test
