#include "brim/scene/pairs/pair_log.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "brim/core/error.h"

/// Figures that outlive the process that made them.
namespace brim::pair_log_test {
namespace {

namespace fs = std::filesystem;

class PairLogTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove(path_); }
  void TearDown() override { fs::remove(path_); }

  std::string path_ = (fs::temp_directory_path() / ("brim_pair_log_" + std::to_string(::getpid()) + ".jsonl")).string();
  PairTable table_ = standard_pairs();
  const PairKind& a_ = table_.kinds[2];
  const PairKind& b_ = table_.kinds[3];

  static PairResult figures() {
    PairResult r;
    r.lower = "rigid", r.upper = "articulated", r.failures = {"energy grew by 2 %", "1 % leaked"};
    r.contacts = 12, r.steps = 80, r.linear = 1.0 / 3.0, r.lever = -1.0, r.energy = 0.02, r.carried = 0.9;
    r.speed = std::numeric_limits<double>::quiet_NaN();
    return r;
  }
};

TEST_F(PairLogTest, GivesBackWhatWasAddedToTheLastBit) {
  PairLog(path_, "1").add(table_, a_, b_, figures());
  const PairLog log(path_, "1");
  const PairResult* r = log.find(table_, a_, b_);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->lower, "rigid");
  EXPECT_EQ(r->upper, "articulated");
  EXPECT_EQ(r->failures, figures().failures);
  EXPECT_EQ(r->contacts, 12);
  EXPECT_EQ(r->steps, 80);
  EXPECT_EQ(r->linear, 1.0 / 3.0);
  EXPECT_EQ(r->lever, -1.0);
  EXPECT_EQ(r->energy, 0.02);
  EXPECT_EQ(r->carried, 0.9);
  EXPECT_TRUE(std::isnan(r->speed));
  EXPECT_TRUE(r->run);
}

TEST_F(PairLogTest, FiguresOfAnotherVersionSceneOrBoundAreNotTaken) {
  PairLog(path_, "1").add(table_, a_, b_, figures());
  const PairLog log(path_, "1");
  EXPECT_FALSE(PairLog(path_, "2").find(table_, a_, b_));
  EXPECT_FALSE(log.find(table_, b_, a_));
  PairTable other = table_;
  other.cut(3);
  EXPECT_FALSE(log.find(other, a_, b_));
  other = table_;
  other.bounds.energy *= 2.0;
  EXPECT_FALSE(log.find(other, a_, b_));
  other = table_;
  other.kinds[2].lever = 1.0;
  EXPECT_FALSE(log.find(other, other.kinds[2], other.kinds[3]));
  other = table_.in_world("fine");
  EXPECT_FALSE(log.find(other, other.kinds[2], other.kinds[3]));
  other = table_;
  other.notes.clear();
  EXPECT_TRUE(log.find(other, a_, b_)) << "why pairs fail decides no figure";
}

TEST_F(PairLogTest, ALineThatWasCutShortIsRunAgainAndTheRestGoesOn) {
  PairLog log(path_, "1");
  log.add(table_, a_, b_, figures());
  log.add(table_, b_, b_, figures());
  fs::resize_file(path_, fs::file_size(path_) - 7);
  PairLog again(path_, "1");
  EXPECT_TRUE(again.find(table_, a_, b_));
  EXPECT_FALSE(again.find(table_, b_, b_));
  again.add(table_, b_, b_, figures());
  EXPECT_TRUE(PairLog(path_, "1").find(table_, b_, b_));
}

TEST_F(PairLogTest, AFileOfSomethingElseIsRefusedWithItsLineAndLeftAsItIs) {
  PairLog(path_, "1").add(table_, a_, b_, figures());
  std::ofstream(path_, std::ios::app) << "{\"bodies\": []}\n";
  const auto size = fs::file_size(path_);
  try {
    PairLog log(path_, "1");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find(path_ + ":2:"), std::string::npos) << e.what();
  }
  EXPECT_EQ(fs::file_size(path_), size);
  std::ofstream(path_) << "a letter";  // without an end of its line
  EXPECT_THROW(PairLog(path_, "1"), InputError);
  EXPECT_EQ(fs::file_size(path_), 8u);
}

TEST_F(PairLogTest, WhatIsKeptIsNotRunAgain) {
  PairLog log(path_, "1");
  int ran = 0;
  const auto run = [&](const PairTable& t, const PairKind& a, const PairKind& b) {
    if (const PairResult* kept = log.find(t, a, b)) return *kept;
    ++ran;
    PairResult r;
    r.lower = a.name, r.upper = b.name;
    log.add(t, a, b, r);
    return r;
  };
  const std::size_t pairs = run_pairs(table_, {"rod"}, {}, run).size();
  EXPECT_EQ(ran, static_cast<int>(pairs));
  EXPECT_EQ(run_pairs(table_, {"rod"}, {}, run).size(), pairs);
  EXPECT_EQ(ran, static_cast<int>(pairs));
}

}  // namespace
}  // namespace brim::pair_log_test
