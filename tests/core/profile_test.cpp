#include "brim/core/profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <string>
#include <thread>

#include "brim/core/parallel.h"

namespace brim::profile_test {
namespace {

struct Named {
  std::string word;
  std::string_view kind() const { return word; }
};

void wait(double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
  }
}

const ProfileEntry* find(const std::vector<ProfileEntry>& entries, const std::string& phase, const std::string& kind) {
  for (const ProfileEntry& e : entries)
    if (e.phase == phase && e.kind == kind) return &e;
  return nullptr;
}

TEST(Profile, Off_NothingIsCounted) {
  set_profile(true);
  set_profile(false);
  {
    const ProfileScope scope("off");
    profile_bytes(8.0);
    profile_count("off count");
  }
  EXPECT_EQ(find(profile_entries(), "off", ""), nullptr);
  for (const ProfileCount& c : profile_counts()) EXPECT_NE(c.name, "off count");
}

TEST(Profile, ThreadsAndKinds_AddUp) {
  const Named hard{"hard"}, soft{"soft"};
  set_profile(true);
  parallel_for(100, [&](std::size_t i) {
    const ProfileScope scope("work", i % 4 == 0 ? hard : soft);
    profile_bytes(10.0);
    profile_count("pieces", static_cast<double>(i));
  });
  set_profile(false);
  const auto entries = profile_entries();
  const ProfileEntry *h = find(entries, "work", "hard"), *s = find(entries, "work", "soft");
  ASSERT_TRUE(h != nullptr && s != nullptr);
  EXPECT_EQ(h->calls, 25);
  EXPECT_EQ(s->calls, 75);
  EXPECT_EQ(s->bytes, 750.0);
  const auto counts = profile_counts();
  ASSERT_EQ(counts.size(), 1u);
  EXPECT_EQ(counts[0].times, 100);
  EXPECT_EQ(counts[0].sum, 4950.0);
  EXPECT_EQ(counts[0].largest, 99.0);
}

TEST(Profile, ScopesInside_TakeTheirTimeFromTheOuterOne) {
  double least = 1.0;  // [s] of the outer scope: a machine with other work to do may stop it at any time
  for (int attempt = 0; attempt < 20 && least >= 0.01; ++attempt) {
    set_profile(true);
    {
      const ProfileScope outer("outer");
      profile_bytes(1.0);
      {
        const ProfileScope inner("inner");
        wait(0.02);
        profile_bytes(2.0);
      }
      profile_bytes(4.0);
    }
    set_profile(false);
    const auto entries = profile_entries();
    const ProfileEntry *outer = find(entries, "outer", ""), *inner = find(entries, "inner", "");
    ASSERT_TRUE(outer != nullptr && inner != nullptr);
    EXPECT_GE(inner->seconds, 0.02);
    EXPECT_EQ(outer->bytes, 5.0);
    EXPECT_EQ(inner->bytes, 2.0);
    least = std::min(least, outer->seconds);
  }
  EXPECT_LT(least, 0.01);
}

TEST(Profile, SetOnAgain_StartsFromZero) {
  set_profile(true);
  { const ProfileScope scope("again"); }
  set_profile(true);
  { const ProfileScope scope("again"); }
  set_profile(false);
  const auto entries = profile_entries();
  const ProfileEntry* e = find(entries, "again", "");
  ASSERT_NE(e, nullptr);
  EXPECT_EQ(e->calls, 1);
}

}  // namespace
}  // namespace brim::profile_test
