#include "brim/core/interface_of.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace brim::interface_of_test {
namespace {

struct Base {
  virtual ~Base() = default;
  double first = 1.0;
};
struct Wet {
  virtual ~Wet() = default;
  int drops = 3;
};
struct Warm {
  virtual ~Warm() = default;
  int degrees = 20;
};

struct Dry final : Base {};
struct Pond final : Base, Wet {};
struct Spring final : Base, Warm, Wet {};
struct Bath final : Warm, Wet, Base {};  // the object that is asked does not come first
template <int N>
struct Kind final : Base, Warm {};

template <class T>
void expect_as_cast(Base& object) {
  EXPECT_EQ(interface_of<T>(object), dynamic_cast<T*>(&object));
  EXPECT_EQ(interface_of<T>(static_cast<const Base&>(object)), dynamic_cast<const T*>(&object));
}

TEST(InterfaceOf, IsWhatADynamicCastGives_AgainAndAgainAndForMoreTypesThanItKeeps) {
  std::vector<std::unique_ptr<Base>> objects;
  for (int copy = 0; copy < 2; ++copy) {
    objects.push_back(std::make_unique<Dry>());
    objects.push_back(std::make_unique<Pond>());
    objects.push_back(std::make_unique<Spring>());
    objects.push_back(std::make_unique<Bath>());
    [&]<int... N>(std::integer_sequence<int, N...>) { (objects.push_back(std::make_unique<Kind<N>>()), ...); }
    (std::make_integer_sequence<int, 20>());
  }
  for (int round = 0; round < 3; ++round)
    for (const auto& object : objects) {
      expect_as_cast<Wet>(*object);
      expect_as_cast<Warm>(*object);
    }
  EXPECT_EQ(interface_of<Wet>(*objects[3])->drops, 3);
}

}  // namespace
}  // namespace brim::interface_of_test
