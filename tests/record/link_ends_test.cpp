#include <gtest/gtest.h>

#include "brim/world/attachment.h"
#include "support/recorded_fall.h"

/// What a run records of where attachments and joints hold.
namespace brim::link_ends_test {
namespace {

using testing::Run;

/// A door on a hinge, a ball on a rope from the door, a ball that a short thread does not hold for long, and a box that
/// is carried by a moving point.
const char* const kWired = R"({
  "brim": 1, "name": "wired", "frames": 20, "world": {"time_step": 0.01, "voxel_size": 0.05},
  "bodies": [
    {"kind": "rigid", "name": "door", "shape": {"kind": "box", "size": [0.8, 0.1, 0.6]}, "transform": {"position": [0.5, 0, 2]}},
    {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.1}, "transform": {"position": [0.9, 0, 1]}},
    {"kind": "rigid", "name": "heavy", "shape": {"kind": "sphere", "radius": 0.2}, "transform": {"position": [3, 0, 1]},
     "velocity": [0, 0, -1]},
    {"kind": "rigid", "name": "box", "shape": {"kind": "box", "size": [0.2, 0.2, 0.2]}, "transform": {"position": [-2, 0, 1]}}
  ],
  "joints": [{"name": "hinge", "kind": "revolute", "body": "door", "position": [0.1, 0, 2], "axis": [0, 1, 0], "damping": 1}],
  "attachments": [
    {"name": "rope", "body": "ball", "to": "door", "point": [0.9, 0, 1.1], "to_point": [0.9, 0, 1.7], "pulls_only": true},
    {"name": "thread", "body": "heavy", "point": [3, 0, 1.2], "break_force": 10},
    {"name": "lift", "body": "box", "point": [-2, 0, 1.1], "keyframes": [{"time": 0}, {"time": 1, "offset": [0, 0, 1]}]}
  ]
})";

TEST_F(Run, EndsOfAttachmentsAreThoseOfTheBodiesUntilTheyBreak) {
  const Scene scene = parse_scene(kWired);
  World world = build_world(scene);
  std::vector<std::vector<Attachment>> seen;
  const auto look = [&] {
    seen.emplace_back();
    for (int i = 0; i < world.attachment_count(); ++i) seen.back().push_back(world.attachment(i));
  };
  look();
  record_run(world, plan(scene, at("run")), [&](const RunProgress&) {
    look();
    return true;
  });
  const RunReader run(at("run"));
  const auto number = [&](const char* name) {
    const std::vector<std::string> names = run.link_names();
    return static_cast<std::int32_t>(std::ranges::find(names, name) - names.begin());
  };
  const std::int32_t hinge = number("hinge"), rope = number("rope"), thread = number("thread"), lift = number("lift");
  ASSERT_EQ(run.link_kinds().size(), 4u);
  EXPECT_EQ(run.link_kinds()[static_cast<std::size_t>(hinge)], "hinge");
  EXPECT_EQ(run.link_kinds()[static_cast<std::size_t>(rope)], "point");
  using Two = std::pair<int, int>;
  const std::vector<Two> bodies = run.link_bodies();
  ASSERT_EQ(bodies.size(), 4u);
  EXPECT_EQ(bodies[static_cast<std::size_t>(hinge)], (Two{0, -1})) << "the door, to space";
  EXPECT_EQ(bodies[static_cast<std::size_t>(rope)], (Two{1, 0})) << "the ball, to the door";
  EXPECT_EQ(bodies[static_cast<std::size_t>(lift)], (Two{3, -1}));
  const auto of = [](const std::vector<RecordedEnd>& all, std::int32_t link) {
    std::vector<RecordedEnd> some;
    for (const RecordedEnd& e : all)
      if (e.link == link) some.push_back(e);
    return some;
  };
  ASSERT_EQ(run.frames(), 21);
  for (std::int64_t f = 0; f < run.frames(); ++f) {
    SCOPED_TRACE(f);
    const std::vector<RecordedEnd> ends = run.link_ends(f);
    std::size_t at = 0;
    for (std::int32_t i = 0; i < 4; ++i)
      for (const auto& [a, b] : seen[static_cast<std::size_t>(f)][static_cast<std::size_t>(i)].ends) {
        ASSERT_LT(at, ends.size());
        EXPECT_EQ(ends[at].link, i);
        EXPECT_EQ(ends[at].a, Vec3f(a.cast<float>()));
        EXPECT_EQ(ends[at++].b, Vec3f(b.cast<float>()));
      }
    EXPECT_EQ(at, ends.size());
    // By what the bodies do.
    const Vec3 ball(run.state(f).q.data() + 7);
    ASSERT_EQ(of(ends, rope).size(), 1u);
    EXPECT_NEAR((of(ends, rope)[0].a.cast<double>() - ball).norm(), 0.1, 1e-6) << "on the ball";
    ASSERT_EQ(of(ends, hinge).size(), 2u);
    const Vec3f axis = of(ends, hinge)[0].b - of(ends, hinge)[1].b;
    EXPECT_NEAR(std::abs(axis.normalized().y()), 1.0, 1e-6);
    ASSERT_EQ(of(ends, lift).size(), 1u);
    EXPECT_NEAR(of(ends, lift)[0].b.z(), 1.1 + run.time(f), 1e-6) << "where the keyframes have it";
  }
  EXPECT_EQ(of(run.link_ends(0), thread).size(), 1u);
  EXPECT_TRUE(of(run.link_ends(20), thread).empty()) << "it broke";
  EXPECT_TRUE(run.links(20)[static_cast<std::size_t>(thread)].broken);
}

TEST_F(Run, EndsOfAttachmentsOfAResumedRunAreThoseOfTheStraightOne) {
  const Scene scene = parse_scene(kWired);
  World straight = build_world(scene);
  record_run(straight, plan(scene, at("straight")), {});
  World first = build_world(scene);
  record_run(first, plan(scene, at("parts")), [](const RunProgress& p) { return p.frame < 9; });
  World second = build_world(scene);
  record_run(second, resumed(scene, at("parts")), {});
  EXPECT_EQ(straight.hash(), second.hash());
  const RunReader a(at("straight")), b(at("parts"));
  for (std::int64_t f = 0; f < a.frames(); ++f) {
    const std::vector<RecordedEnd> x = a.link_ends(f), y = b.link_ends(f);
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_TRUE(x[i].a == y[i].a && x[i].b == y[i].b) << f;
  }
}

TEST_F(Run, WithoutAttachmentsThereAreNoEnds) {
  const Scene scene = parse_scene(testing::kScene);
  World world = build_world(scene);
  record_run(world, plan(scene, at("run")), {});
  EXPECT_TRUE(RunReader(at("run")).link_ends(3).empty());
  EXPECT_TRUE(RunReader(at("run")).link_kinds().empty());
  EXPECT_TRUE(RunReader(at("run")).link_bodies().empty());
}

}  // namespace
}  // namespace brim::link_ends_test
