#include "brim/core/stop.h"

#include <gtest/gtest.h>

#include <thread>

namespace brim::stop_test {
namespace {

TEST(Stop, WorkEndsWhereItLooksOnceItIsAskedTo) {
  int asked = 0;
  const StopScope::Asked third = [&] { return ++asked == 3; };
  const StopScope scope(third);
  check_stop();
  check_stop();
  EXPECT_THROW(check_stop(), Stopped);
}

TEST(Stop, TheInnermostScopeIsAskedAndNobodyOutsideOfAll) {
  const StopScope::Asked yes = [] { return true; }, no = [] { return false; };
  EXPECT_NO_THROW(check_stop());
  {
    const StopScope outer(yes);
    {
      const StopScope inner(no);
      EXPECT_NO_THROW(check_stop());
    }
    {
      const StopScope nobody(StopScope::Asked{});
      EXPECT_NO_THROW(check_stop());
    }
    EXPECT_THROW(check_stop(), Stopped);
  }
  EXPECT_NO_THROW(check_stop());
}

TEST(Stop, AScopeIsOfItsThreadAlone) {
  const StopScope::Asked yes = [] { return true; };
  const StopScope scope(yes);
  bool ended = false;
  std::thread([&] {
    try {
      check_stop();
    } catch (const Stopped&) {
      ended = true;
    }
  }).join();
  EXPECT_FALSE(ended);
}

}  // namespace
}  // namespace brim::stop_test
