#include "brim/world/contact_preconditioner.h"

#include <gtest/gtest.h>

namespace brim::testing::contact_preconditioner_test {
namespace {

/// Four contacts along z, of which number 2 is in no row.
struct Contacts {
  ContactRows rows;
  std::vector<std::uint8_t> acting{1, 1, 0, 1};
  std::vector<double> stiffness{5.0, 5.0, 5.0, 5.0};

  Contacts() {
    for (const std::uint32_t c : {0u, 1u, 3u}) {
      rows.contact.push_back(c);
      rows.stiffness.push_back(block(c).cast<float>());
    }
  }
  Mat3 block(std::size_t c) const { return stiffness[c] * Vec3::UnitZ() * Vec3::UnitZ().transpose(); }
  std::size_t changed() const {
    return count_changed(rows, acting, [&](std::size_t c) { return block(c); });
  }
};

TEST(ContactPreconditioner, WhatIsAsItWasHasNotChanged) { EXPECT_EQ(Contacts().changed(), 0u); }

TEST(ContactPreconditioner, CountsContactsThatLetGoAndThatCome) {
  Contacts c;
  c.acting[3] = 0;
  EXPECT_EQ(c.changed(), 1u);
  c.acting[2] = 1;
  EXPECT_EQ(c.changed(), 2u);
}

TEST(ContactPreconditioner, CountsStiffnessThatIsMoreThanTwiceOrLessThanHalf) {
  Contacts c;
  c.stiffness = {9.9, 2.6, 5.0, 5.0};
  EXPECT_EQ(c.changed(), 0u);
  c.stiffness = {10.1, 2.4, 5.0, 5.0};
  EXPECT_EQ(c.changed(), 2u);
}

TEST(ContactPreconditioner, TellsStiffnessInAnotherDirection) {
  Contacts c;
  c.rows.stiffness[0] = 5.0f * Eigen::Vector3f::UnitX() * Eigen::Vector3f::UnitX().transpose();
  EXPECT_EQ(c.changed(), 1u);
}

}  // namespace
}  // namespace brim::testing::contact_preconditioner_test
