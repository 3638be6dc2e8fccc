#include "brim/world/fluid_warnings.h"

#include <gtest/gtest.h>

#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "support/worlds.h"

namespace brim::fluid_warnings_test {
namespace {

std::unique_ptr<GridFluidBody> pool(const char* name, double from, double to, double density,
                                    const Vec3& u = Vec3::Zero()) {
  GridFluidModel m;
  m.grid = {Vec3::Zero(), 0.1, {4, 4, 6}};
  m.density = density;
  m.distance = [=](const Vec3& x) { return std::max(from - x.z(), x.z() - to); };
  m.velocity = [=](const Vec3&) { return u; };
  auto b = std::make_unique<GridFluidBody>(std::move(m));
  b->set_name(name);
  return b;
}

int count(const StepReport& r, std::string_view code) {
  return static_cast<int>(std::ranges::count_if(r.warnings, [&](const Warning& w) { return w.code == code; }));
}

TEST(FluidWarnings, TwoFluidsThatMayMeetAreSaidOnce) {
  World w(testing::options_at(0.1));
  w.add(pool("water", -1.0, 0.2, 1000.0));
  EXPECT_EQ(count(w.step(), "two_fluids"), 0);
  World both(testing::options_at(0.1));
  both.add(pool("water", -1.0, 0.2, 1000.0));
  both.add(pool("oil", 0.2, 0.4, 800.0));
  EXPECT_EQ(count(both.step(), "two_fluids"), 1);
  EXPECT_EQ(count(both.step(), "two_fluids"), 0);
}

TEST(FluidWarnings, AFluidFasterThanSoundEndsTheRun) {
  for (const double speed : {1000.0, 3000.0}) {
    WorldOptions o = testing::options_at(0.1);
    o.time_step = 1e-6;
    o.environment.gravity = Vec3::Zero();
    World w(o);
    w.add(pool("water", 0.2, 0.4, 1000.0, Vec3(0.0, 0.0, -speed)));
    const StepReport r = w.step();
    EXPECT_EQ(r.ok, speed < 1500.0) << r.max_speed;
    EXPECT_EQ(count(r, "runaway_fluid"), speed < 1500.0 ? 0 : 1);
  }
}

}  // namespace
}  // namespace brim::fluid_warnings_test
