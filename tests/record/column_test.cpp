#include "brim/record/column.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <random>

#include "brim/core/error.h"

namespace brim::column_test {
namespace {

namespace fs = std::filesystem;
using h5::File;
using h5::Type;

class Columns : public ::testing::Test {
 protected:
  std::string path_ = (fs::temp_directory_path() / fmt::format("brim_column_{}.h5", ::getpid())).string();
  void TearDown() override { fs::remove(path_); }

  std::vector<double> in_file() const {
    const File file(path_, File::Mode::Read);
    const h5::Dataset set = file.open("/x");
    const std::uint64_t rows = set.shape()[0];
    std::vector<double> x(2 * rows);
    if (rows > 0) set.read(x.data(), x.size(), 0, rows, Type::Float64);
    return x;
  }
};

TEST_F(Columns, WhatIsReadBackIsWhatWasAppendedWhateverThePiecesFlushesAndCuts) {
  const unsigned seed = 11;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::vector<double> wanted;
  for (int life = 0; life < 4; ++life) {
    File file(path_, life == 0 ? File::Mode::Create : File::Mode::Write);
    Column column = life == 0 ? Column(file, "/x", Type::Float64, {2}, 7) : Column(file.open("/x"));
    EXPECT_EQ(column.rows(), wanted.size() / 2);
    for (int n = 0; n < 60; ++n) {
      std::vector<double> rows(2 * (random() % 25));
      for (double& x : rows) x = static_cast<double>(random());
      column.append(rows.data(), rows.size() / 2);
      wanted.insert(wanted.end(), rows.begin(), rows.end());
      if (random() % 8 == 0) column.flush();
      if (random() % 10 == 0) {
        const std::size_t kept = random() % (wanted.size() / 2 + 1);
        column.cut(kept);
        wanted.resize(2 * std::min(kept, wanted.size() / 2));
      }
    }
    column.flush();
    file.flush();
    EXPECT_EQ(in_file(), wanted) << "while the writer has it open";
  }
  EXPECT_GT(wanted.size(), 100u);
}

TEST_F(Columns, RowsWithoutNumbersAreCounted) {
  File file(path_, File::Mode::Create);
  Column column(file, "/x", Type::Float32, {0, 3}, 4);
  column.append(nullptr, 9);
  column.flush();
  EXPECT_EQ(column.set().shape(), (std::vector<std::uint64_t>{9, 0, 3}));
}

TEST_F(Columns, DataOfAnotherShapeOrTypeIsRefusedBeforeItIsRead) {
  File file(path_, File::Mode::Create);
  Column column(file, "/x", Type::Int32, {2}, 4);
  const std::int32_t rows[] = {1, 2, 3, 4};
  column.append(rows, 2);
  column.flush();
  std::int32_t room[4] = {};
  EXPECT_THROW(column.set().read(room, 3, 0, 2, Type::Int32), InputError) << "no room";
  EXPECT_THROW(column.set().read(room, 4, 1, 2, Type::Int32), InputError) << "beyond the end";
  EXPECT_THROW(column.set().read(room, 4, ~std::uint64_t{0}, 2, Type::Int32), InputError);
  EXPECT_THROW(column.set().read(room, 4, 0, 2, Type::Float32), InputError) << "other type";
  EXPECT_NO_THROW(column.set().read(room, 4, 0, 2, Type::Int32));
  EXPECT_EQ(room[3], 4);
  const std::vector<std::uint64_t> three = {3}, none;
  EXPECT_THROW(column.set().need_rows(0, 2, three), InputError);
  EXPECT_THROW(column.set().need_rows(0, 2, none), InputError);
}

TEST_F(Columns, AShapeThatSaysMoreThanTheFileStoresIsRefused) {
  File file(path_, File::Mode::Create);
  h5::Dataset set = file.growing("/x", Type::Float64, {}, 8, 0);
  set.set_rows(std::uint64_t{1} << 36);  // nothing is allocated in the file
  EXPECT_THROW(set.need_rows(0, std::uint64_t{1} << 36, {}), InputError);
}

}  // namespace
}  // namespace brim::column_test
