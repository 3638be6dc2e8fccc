#include "brim/world/sense/strain_sensor.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "support/carried.h"
#include "support/sensing.h"
#include "support/soft_worlds.h"

/// Laws of probes of strain and distance.
namespace brim {
namespace {

using namespace testing::sensing;

SensorModel strain_of(const std::string& body) {
  SensorModel m = sensor_on(SensorKind::Strain, body, body);
  m.region = [](const Vec3&) { return true; };
  return m;
}

/// Moves every node by x -> A x, and reads.
void deform(World& w, const Mat3& A) {
  State s = w.state();
  for (std::size_t i = 0; i + 2 < s.q.size(); i += 3) {
    const Vec3 x = A * Vec3(s.q[i], s.q[i + 1], s.q[i + 2]);
    s.q[i] = x.x(), s.q[i + 1] = x.y(), s.q[i + 2] = x.z();
  }
  w.set_state(s);
  sensors_of(w).end_step(w, StepReport{});
}

TEST(StrainSensor, AffineDeformationsAreReadExactly) {
  Mat3 A;
  A << 1.2, 0.1, 0.0, 0.0, 0.9, 0.05, 0.0, 0.0, 1.1;
  const Mat3 E = 0.5 * (A.transpose() * A - Mat3::Identity());
  World w(options_at(0.1));
  w.add(testing::jelly("jelly", 0.5, Vec3(0, 0, 2)));
  add_sensor(w, strain_of("jelly"));
  deform(w, A);
  EXPECT_NEAR(reading(w, "jelly", "strain_xx"), E(0, 0), 1e-6);
  EXPECT_NEAR(reading(w, "jelly", "strain_zz"), E(2, 2), 1e-6);
  EXPECT_NEAR(reading(w, "jelly", "strain_xy"), E(0, 1), 1e-6);
  EXPECT_NEAR(reading(w, "jelly", "strain_yz"), E(1, 2), 1e-6);
}

TEST(StrainSensor, RigidMotionsStrainNothing) {
  const Mat3 R = Quat(Eigen::AngleAxisd(2.0, Vec3(1, 2, 3).normalized())).toRotationMatrix();
  World w(options_at(0.1));
  w.add(testing::jelly("jelly", 0.5, Vec3(0, 0, 2)));
  w.add(testing::sheet("sheet", 0.8, Vec3(2, 0, 2)));
  w.add(testing::rope("rope", Vec3(0, 3, 0), Vec3(1, 3, 0)));
  for (const std::string body : {"jelly", "sheet", "rope"}) add_sensor(w, strain_of(body));
  deform(w, R);
  for (const std::string body : {"jelly", "sheet", "rope"}) {
    EXPECT_NEAR(reading(w, body, "largest"), 0.0, 1e-6) << body;
    EXPECT_NEAR(reading(w, body, "least"), 0.0, 1e-6) << body;
  }
}

TEST(StrainSensor, SheetsAndRodsAreStrainedWhereTheyLie) {
  World w(options_at(0.1));
  w.add(testing::sheet("sheet", 0.8, Vec3(2, 0, 2)));
  w.add(testing::rope("rope", Vec3(0, 3, 0), Vec3(1, 3, 0)));
  for (const std::string body : {"sheet", "rope"}) add_sensor(w, strain_of(body));
  deform(w, Vec3(1.1, 1.0, 5.0).asDiagonal());  // across sheet and rope nothing is strained
  for (const std::string body : {"sheet", "rope"}) {
    EXPECT_NEAR(reading(w, body, "strain_xx"), 0.5 * (1.21 - 1), 1e-6) << body;
    EXPECT_NEAR(reading(w, body, "largest"), 0.5 * (1.21 - 1), 1e-6) << body;
  }
  EXPECT_NEAR(reading(w, "sheet", "least"), 0.0, 1e-6);
}

TEST(DistanceSensor, ReadsLengthStrainAndRate) {
  World w(options_at(0.1));
  w.add(testing::jelly("jelly", 0.5, Vec3(0, 0, 2)));
  SensorModel m = sensor_on(SensorKind::Distance, "jelly");
  m.point = Vec3(0, 0, 2), m.to = "jelly", m.to_point = Vec3(0.5, 0, 2);
  add_sensor(w, m);
  m.name = "floor", m.to = "", m.to_point = Vec3(0, 0, 0);
  add_sensor(w, m);
  EXPECT_NEAR(reading(w, "floor", "distance"), 2.0, 1e-9);
  w.step();
  EXPECT_NEAR(reading(w, "floor", "rate"), -9.81 / 60, 1e-3);
  EXPECT_NEAR(reading(w, "sensor", "strain"), 0.0, 1e-3);
  deform(w, Vec3(1.1, 1, 1).asDiagonal());
  EXPECT_NEAR(reading(w, "sensor", "strain"), 0.1, 1e-3);
  EXPECT_NEAR(reading(w, "sensor", "distance"), 0.55, 1e-3);
}

TEST(StrainSensor, VolumesAreStrainedAsTheMatterThatCarriesThem) {
  Mat3 A;
  A << 1.1, 0.1, 0.0, 0.0, 0.9, 0.05, 0.0, 0.0, 1.05;
  const Mat3 E = 0.5 * (A.transpose() * A - Mat3::Identity());
  World w(options_at(0.05));
  auto scan = testing::voxels(Vec3(0.4, 0.4, 0.4), 0.1, 0.025, testing::soft(), Vec3(0, 0, 2));
  scan->set_name("scan");
  w.add(std::move(scan));
  add_sensor(w, strain_of("scan"));
  deform(w, A);
  EXPECT_NEAR(reading(w, "scan", "strain_xx"), E(0, 0), 1e-6);
  EXPECT_NEAR(reading(w, "scan", "strain_xy"), E(0, 1), 1e-6);
  EXPECT_NEAR(reading(w, "scan", "strain_yz"), E(1, 2), 1e-6);
}

TEST(StrainSensor, RegionsWithoutVerticesAreRefused) {
  World w(options_at(0.1));
  w.add(testing::jelly("jelly", 0.5, Vec3(0, 0, 2)));
  SensorModel m = strain_of("jelly");
  m.region = [](const Vec3& x) { return x.z() > 100.0; };
  EXPECT_THROW(add_sensor(w, m), InputError);
}

}  // namespace
}  // namespace brim
