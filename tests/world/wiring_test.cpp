#include "brim/world/wiring.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/world/applied_force.h"
#include "brim/world/attachment.h"
#include "brim/world/world.h"
#include "support/soft_worlds.h"

/// States bring back which attachments, targets of joints and forces existed.
namespace brim::wiring_test {
namespace {

using testing::box;
using testing::options_at;

World world_with_box() {
  WorldOptions o = options_at(0.1);
  World w(o);
  w.add(box("box", {Vec3(0, 0, 1)}, 0.5, 0.2));
  return w;
}

Attachment pin(const std::string& name, const Vec3& at = Vec3(0, 0, 1)) {
  Attachment a;
  a.name = name, a.body = "box", a.point = at;
  return a;
}

AppliedForce push(const std::string& name) {
  AppliedForce f;
  f.name = name, f.bodies = {"box"}, f.force = Vec3(3, 0, 0), f.gravity_scale = 0.5;
  return f;
}

std::uint64_t hash_after(World& w, int steps) {
  for (int i = 0; i < steps; ++i) w.step();
  return w.hash();
}

TEST(Wiring, AnEarlierStateTakesAwayWhatWasAddedSinceAndALaterOneBringsItBack) {
  World w = world_with_box();
  const State bare = w.state();
  const std::uint64_t falls = hash_after(w, 10);
  w.set_state(bare);
  w.attach(pin("cup"));
  w.apply(push("wind"));
  w.step();
  const State held = w.state();
  const std::uint64_t hangs = hash_after(w, 10);
  EXPECT_NE(hangs, falls);
  w.set_state(bare);
  EXPECT_EQ(w.attachment_count(), 0);
  EXPECT_EQ(w.force_count(), 0);
  EXPECT_EQ(hash_after(w, 10), falls);
  w.set_state(held);
  ASSERT_EQ(w.attachment_count(), 1);
  EXPECT_EQ(w.attachment(0).name, "cup");
  EXPECT_EQ(hash_after(w, 10), hangs);
}

TEST(Wiring, ADetachedOneComesBackOnlyInStatesInWhichItHeld) {
  World w = world_with_box();
  const State bare = w.state();
  const std::uint64_t falls = hash_after(w, 10);
  w.set_state(bare);
  w.attach(pin("cup"));
  w.step();
  const State held = w.state();
  w.detach(0);
  const State let_go = w.state();
  w.set_state(bare);
  EXPECT_EQ(hash_after(w, 10), falls);
  w.set_state(let_go);
  EXPECT_TRUE(w.detached(0));
  w.set_state(held);
  EXPECT_FALSE(w.detached(0));
}

TEST(Wiring, TheSameNameMayBeGivenAgainAfterAnEarlierStateAndEachStateHasItsOwn) {
  World w = world_with_box();
  const State bare = w.state();
  w.attach(pin("cup"));
  const std::int64_t first = w.attachment_id(0);
  const State low = w.state();
  const std::uint64_t by_the_middle = hash_after(w, 10);
  w.set_state(bare);
  w.attach(pin("cup", Vec3(0.1, 0, 1)));
  EXPECT_NE(w.attachment_id(0), first);
  EXPECT_NE(hash_after(w, 10), by_the_middle);
  w.set_state(low);
  EXPECT_EQ(w.attachment_id(0), first);
  EXPECT_EQ(hash_after(w, 10), by_the_middle);
}

TEST(Wiring, TheAimOfAJointsDriveIsPartOfTheState) {
  World w = world_with_box();
  Attachment hinge;
  hinge.name = "hinge", hinge.body = "box";
  LinkJoint& joint = hinge.joint.emplace();
  joint.kind = JointKind::Revolute, joint.position = Vec3(0, 0, 1), joint.axis = Vec3(0, 1, 0);
  joint.drive.stiffness = 100, joint.drive.damping = 5;
  w.attach(hinge);
  const State before = w.state();
  const std::uint64_t at_rest = hash_after(w, 10);
  w.set_state(before);
  w.set_drive(0, 0.5, 0.0);
  w.step();
  const State aimed = w.state();
  const std::uint64_t turned = hash_after(w, 10);
  EXPECT_NE(turned, at_rest);
  w.set_state(before);
  EXPECT_EQ(hash_after(w, 10), at_rest);
  w.set_state(aimed);
  EXPECT_EQ(hash_after(w, 10), turned);
  State recorded = aimed;
  recorded.wiring = nullptr;
  World other = world_with_box();
  other.attach(hinge);
  other.set_state(recorded);
  EXPECT_EQ(hash_after(other, 10), turned) << "a resumed run";
}

TEST(Wiring, AStateOfAnotherWorldNeedsWhatItHasByName) {
  World w = world_with_box();
  w.attach(pin("cup"));
  w.apply(push("wind"));
  w.step();
  const State held = w.state();
  World other = world_with_box();
  try {
    other.set_state(held);
    FAIL() << "the attachment is not there";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("attachment 'cup'"), std::string::npos) << e.what();
  }
  other.attach(pin("more", Vec3(0, 0, 0.9)));
  other.attach(pin("cup"));
  other.apply(push("wind"));
  other.set_state(held);
  EXPECT_EQ(other.attachment_count(), 1) << "only what the state has";
  EXPECT_EQ(hash_after(other, 10), hash_after(w, 10));
}

}  // namespace
}  // namespace brim::wiring_test
