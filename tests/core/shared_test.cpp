#include "brim/core/shared.h"

#include <gtest/gtest.h>

namespace brim::shared_test {
namespace {

struct Pair {
  std::vector<int> first, second;
};

TEST(Shared, CopiesAndListsOfAValueLieWhereItLies) {
  SharedList<int> list;
  const int* second = nullptr;
  {
    const Shared<Pair> whole(Pair{{1, 2}, {3, 4, 5}}), copy = whole;
    EXPECT_EQ(&*copy, &*whole);
    list = copy.list(&Pair::second);
    second = whole->second.data();
  }
  // The list has kept the value.
  EXPECT_EQ(list.data(), second);
  EXPECT_EQ(list, (std::vector<int>{3, 4, 5}));
  EXPECT_EQ(list[1], 4);
}

TEST(Shared, AnEmptyListIsOneOfNothing) {
  const SharedList<int> none;
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.begin(), none.end());
  EXPECT_EQ(none, SharedList<int>(std::vector<int>{}));
  EXPECT_TRUE(Shared<Pair>()->first.empty());
}

}  // namespace
}  // namespace brim::shared_test
