// Velocities of vertices, which other programs take for motion blur.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "brim/core/error.h"
#include "brim/record/export/velocities.h"
#include "support/moving_run.h"
#include "support/text_of.h"

namespace brim::export_velocities_test {
namespace {

namespace fs = std::filesystem;
using exporting::Velocities;
using exporting::VelocitySource;
using testing::text_of;

class ExportVelocities : public ::testing::Test {
 protected:
  WorldAt world_at() {
    return [this](std::int64_t frame) -> const World& { return made_.world_at(frame); };
  }
  int number_of(const std::string& name) const {
    return static_cast<int>(std::ranges::find(run_.bodies(), name, &RecordedBody::name) - run_.bodies().begin());
  }
  fs::path exported(const std::string& format) {
    const fs::path out = made_.path / format;
    export_run(run_, {.format = format, .folder = out.string()}, world_at());
    return out;
  }
  /// Largest difference to the central difference of positions over the frames 1 to 3, [m/s].
  double worst(Velocities& velocities, int body, double& fastest) {
    double worst = 0.0;
    for (const std::int64_t f : {1, 2, 3}) {
      const auto x0 = run_.positions(body, f - 1), x = run_.positions(body, f), x1 = run_.positions(body, f + 1);
      const auto u = velocities.at(body, f, run_.state(f), x);
      EXPECT_EQ(u.size(), x.size());
      const double dt = run_.time(f + 1) - run_.time(f - 1);
      for (std::size_t i = 0; i < u.size(); ++i) {
        const Vec3 rate = (x1[i] - x0[i]).cast<double>() / dt;
        worst = std::max(worst, (u[i].cast<double>() - rate).norm());
        fastest = std::max(fastest, rate.norm());
      }
    }
    return worst;
  }

  testing::MovingRun made_;
  RunReader run_{made_.folder()};
};

TEST_F(ExportVelocities, AreTheRatesOfPositionsForEveryKind) {
  Velocities velocities(run_, world_at());
  for (std::size_t b = 0; b < run_.bodies().size(); ++b) {
    const RecordedBody& body = run_.bodies()[b];
    if (body.changing) continue;
    double fastest = 0.0;
    const double off = worst(velocities, static_cast<int>(b), fastest);
    EXPECT_EQ(fastest > 0.2, body.name != "floor") << body.name;
    // A step of 2 ms is of first order: a velocity is that of the step's end, a few m/s² times half of it off; a link's
    // spin turns on within the frames.
    EXPECT_LT(off, 0.01 * fastest + 1e-9) << body.name;
    EXPECT_NE(velocities.source(static_cast<int>(b)), VelocitySource::Differences) << body.name;
  }
}

TEST_F(ExportVelocities, AreTakenFromWhatIsRecordedWhereThatIsEnough) {
  int asked = 0;
  Velocities velocities(run_, [&](std::int64_t) -> const World& {
    ++asked;
    throw InputError("no world");
  });
  const std::map<std::string, VelocitySource> wanted = {
      {"floor", VelocitySource::Twist}, {"platform", VelocitySource::Twist}, {"box", VelocitySource::Twist},
      {"jelly", VelocitySource::Nodes}, {"sheet", VelocitySource::Nodes},    {"net", VelocitySource::Nodes},
      {"rope", VelocitySource::Nodes},  {"sand", VelocitySource::Nodes},     {"spray", VelocitySource::Nodes}};
  for (const auto& [name, source] : wanted) EXPECT_EQ(velocities.source(number_of(name)), source) << name;
  EXPECT_EQ(asked, 0);
}

TEST_F(ExportVelocities, AreDifferencesOfPositionsWithoutAWorld) {
  Velocities velocities(run_, {});
  for (const char* name : {"arm", "blob", "drop"}) {
    double fastest = 0.0;
    EXPECT_EQ(velocities.source(number_of(name)), VelocitySource::Differences) << name;
    EXPECT_LT(worst(velocities, number_of(name), fastest), 1e-5) << name;
    // At the ends of the run from one side.
    for (const std::int64_t f : {std::int64_t{0}, run_.frames() - 1}) {
      const auto x = run_.positions(number_of(name), f);
      EXPECT_GT(velocities.at(number_of(name), f, run_.state(f), x)[0].norm(), 0.1f) << name;
    }
  }
  EXPECT_EQ(velocities.source(number_of("water")), VelocitySource::None) << "its vertices are others in every frame";
}

TEST_F(ExportVelocities, OfWaterThatFallsAreThoseOfItsFall) {
  Velocities velocities(run_, world_at());
  const int water = number_of("water");
  ASSERT_EQ(velocities.source(water), VelocitySource::Map);
  const std::int64_t f = run_.frames() - 1;
  const auto x = run_.positions(water, f);
  const auto u = velocities.at(water, f, run_.state(f), x);
  ASSERT_EQ(u.size(), x.size());
  // Where the ball of five cells curves within a cell, the flow through its surface is that of a neighbour too.
  const Vec3 fall(0, 0, -9.81 * run_.time(f));
  Vec3 mean = Vec3::Zero();
  for (const Vec3f& w : u) {
    mean += w.cast<double>() / static_cast<double>(u.size());
    EXPECT_LT((w.cast<double>() - fall).norm(), 0.3 * fall.norm());
  }
  EXPECT_LT((mean - fall).norm(), 0.03 * fall.norm());
}

TEST_F(ExportVelocities, AreInEveryFileOfVtkAndPlyAlsoOfABodyThatWasRemoved) {
  const fs::path vtk = exported("vtk"), ply = exported("ply");
  int files = 0;
  for (const auto& [folder, word] : {std::pair{vtk, "Name=\"velocity\" NumberOfComponents=\"3\""},
                                     {ply, "property float vx\nproperty float vy\nproperty float vz\n"}})
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("contacts") || name == "run.pvd" || name == "export.json") continue;
      EXPECT_NE(text_of(entry.path()).find(word), std::string::npos) << name;
      ++files;
    }
  EXPECT_EQ(files, 2 * (1 + 12 * 7));
  EXPECT_NE(text_of(vtk / "net_00006.vtp").find("NumberOfPoints=\"0\""), std::string::npos) << "it was removed";
}

TEST_F(ExportVelocities, OfElementsStayInVtuWhenTheyAreGone) {
  const fs::path vtu = exported("vtu");
  EXPECT_NE(text_of(vtu / "jelly_00006.vtu").find("velocity"), std::string::npos);
}

TEST_F(ExportVelocities, AreInUsdaForAllThatDeforms) {
  const std::string usda = text_of(exported("usda") / "run.usda");
  for (const char* name : {"jelly", "drop", "blob", "sheet", "net", "rope", "sand", "spray", "water"}) {
    const std::size_t prim = usda.find(fmt::format("\"{}\" (", name)), next = usda.find("\n    }\n", prim);
    ASSERT_NE(prim, std::string::npos) << name;
    EXPECT_LT(usda.find("vector3f[] velocities.timeSamples", prim), next) << name;
  }
  // What moves as a whole is blurred by its matrix.
  const std::size_t box = usda.find("\"box\" ("), end = usda.find("\n    }\n", box);
  EXPECT_LT(usda.find("xformOp:transform", box), end);
  EXPECT_GT(usda.find("velocities", box), end);
}

}  // namespace
}  // namespace brim::export_velocities_test
