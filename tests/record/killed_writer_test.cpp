#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "brim/core/error.h"
#include "brim/record/column.h"
#include "brim/record/h5.h"
#include "brim/record/journal.h"

namespace brim::killed_writer_test {
namespace {

namespace fs = std::filesystem;
using h5::File;
using h5::Type;

constexpr int kColumns = 3;  ///< of numbers that count up; chunks of 2 rows, so that HDF5's trees of chunks soon split
constexpr int kFlushes = 45, kRows = 7;
constexpr int kEnded = 0, kCutShort = 77;

/// In the child: changes of the disk until its end. The last is half done where it can be.
int changes_left = -1;

void die_in_time(const DiskWrite& w) {
  if (changes_left < 0 || --changes_left >= 0) return;
  if (w.size > 1 && ::pwrite(w.file, w.data, w.size / 2, static_cast<off_t>(w.at)) < 0) ::_exit(78);
  ::_exit(kCutShort);
}

struct Written {
  File file;
  std::vector<Column> columns;
  h5::Dataset count;
  std::int64_t rows = 0;
};

Written begin(const std::string& path) {
  Written w{File(path, File::Mode::Create), {}, {}, 0};
  for (int c = 0; c < kColumns; ++c)
    w.columns.emplace_back(w.file, fmt::format("/column{}", c), Type::Float64, std::vector<std::uint64_t>{}, 2);
  const std::array<std::uint64_t, 1> one = {1};
  w.file.write("/count", Type::Int64, one, &w.rows);
  w.count = w.file.open("/count");
  return w;
}

/// As RunWriter goes on after a killed process: what was not counted is cut.
Written go_on(const std::string& path) {
  Written w{File(path, File::Mode::Write), {}, {}, 0};
  w.count = w.file.open("/count");
  w.count.read(&w.rows, 1, 0, 1, Type::Int64);
  for (int c = 0; c < kColumns; ++c) {
    w.columns.emplace_back(w.file.open(fmt::format("/column{}", c)));
    w.columns.back().cut(static_cast<std::uint64_t>(w.rows));
  }
  w.file.flush();
  return w;
}

void append_and_flush(Written& w, int rows) {
  for (int r = 0; r < rows; ++r, ++w.rows)
    for (Column& c : w.columns) c.append_value(static_cast<double>(w.rows));
  for (Column& c : w.columns) c.flush();
  w.file.flush();
  w.count.overwrite(&w.rows, Type::Int64);
  w.file.flush();
}

/// Rows that a reader is told of, each checked; -1 where no flush was ever whole.
std::int64_t read_back(const std::string& path) {
  if (h5::never_flushed(path)) return -1;
  const File file(path, File::Mode::Read);
  if (!file.exists("/count")) return -1;
  std::int64_t rows = 0;
  file.open("/count").read(&rows, 1, 0, 1, Type::Int64);
  std::vector<double> wanted(static_cast<std::size_t>(rows)), found(wanted.size());
  std::iota(wanted.begin(), wanted.end(), 0.0);
  for (int c = 0; c < kColumns && rows > 0; ++c) {
    file.open(fmt::format("/column{}", c)).read(found.data(), found.size(), 0, found.size(), Type::Float64);
    EXPECT_EQ(found, wanted);
  }
  return rows;
}

class KilledWriter : public ::testing::Test {
 protected:
  std::string path_ = (fs::temp_directory_path() / fmt::format("brim_killed_{}.h5", ::getpid())).string();
  void TearDown() override {
    fs::remove(path_);
    fs::remove(Journal::path_of(path_));
  }

  /// Writes in a process of its own that ends before its change number `change` of the disk is whole.
  int write_until(int change, int flushes) const {
    const pid_t child = ::fork();
    if (child == 0) {
      watch_disk_writes(die_in_time);
      changes_left = change;
      Written w = begin(path_);
      for (int i = 0; i < flushes; ++i) append_and_flush(w, kRows);
      ::_exit(kEnded);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
};

TEST_F(KilledWriter, AtWhicheverWriteItEndsTheFileIsThatOfAFlushAndCanBeGoneOnWith) {
  std::int64_t before = -1;
  int change = 0;
  // Every change of the disk while the file is made, then each 7th: flushes are alike.
  for (;; change += change < 60 ? 1 : 7) {
    SCOPED_TRACE(fmt::format("ends at change {}", change));
    fs::remove(path_);
    fs::remove(Journal::path_of(path_));
    const int end = write_until(change, kFlushes);
    if (end == kEnded) break;
    ASSERT_EQ(end, kCutShort);
    if (!fs::exists(path_)) continue;
    const std::int64_t rows = read_back(path_);
    EXPECT_GE(rows, before) << "a later end keeps no less";
    before = rows;
    if (rows < 0) continue;
    {
      Written w = go_on(path_);
      EXPECT_EQ(w.rows, rows);
      append_and_flush(w, 3);
    }
    EXPECT_EQ(read_back(path_), rows + 3);
    EXPECT_FALSE(fs::exists(Journal::path_of(path_)));
    if (HasFailure()) return;
  }
  EXPECT_GT(change, 200) << "the writes must be seen, or the test is blind";
  EXPECT_EQ(read_back(path_), kFlushes * kRows);
}

TEST_F(KilledWriter, AJournalThatIsCutOrOfAnotherFileIsNotTakenOver) {
  ASSERT_EQ(write_until(-1, 3), kEnded);
  const std::string before = [&] {
    std::ifstream in(path_, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  }();
  Journal journal;
  const char junk[] = "junk";
  journal.add(0, junk, sizeof junk);
  // A journal that is whole, for a file of another length.
  const std::string other = path_ + ".other";
  { std::ofstream(other) << "another"; }
  std::string text;
  watch_disk_writes([](const DiskWrite&) {});
  {
    const pid_t child = ::fork();
    if (child == 0) {
      watch_disk_writes(die_in_time);
      changes_left = 2;  // the journal is whole, its places are not written
      std::FILE* f = std::fopen(other.c_str(), "r+");
      journal.commit(other, ::fileno(f));
      ::_exit(kEnded);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_EQ(WEXITSTATUS(status), kCutShort);
  }
  watch_disk_writes(nullptr);
  ASSERT_TRUE(fs::exists(Journal::path_of(other)));
  fs::rename(Journal::path_of(other), Journal::path_of(path_));
  fs::remove(other);
  EXPECT_EQ(read_back(path_), 3 * kRows);
  { const File file(path_, File::Mode::Write); }
  EXPECT_EQ(read_back(path_), 3 * kRows);
  EXPECT_EQ(before.substr(0, 8), "\x89HDF\r\n\x1a\n");
}

}  // namespace
}  // namespace brim::killed_writer_test
