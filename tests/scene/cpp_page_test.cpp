#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "brim/body/obstacle/obstacle_body.h"
#include "brim/body/rigid/make_rigid.h"
#include "brim/brim.h"
#include "brim/scene/solid_store.h"
#include "brim/world/attachment.h"
#include "checkout_paths.h"

/// The code of docs/cpp.md: what stands there is here word for word, and runs.
namespace brim::testing::cpp_page_test {
namespace {

/// Its own fragment; examples/cpp_project/main.cpp is a whole program of it.
int step_a_scene() {
  brim::World world = brim::build_world(brim::load_scene("drop.json"));
  for (int step = 0; step < 200; ++step) {
    const brim::StepReport report = world.step();
    if (!report.ok) return 1;  // never throws for numerical trouble: the report says it
  }
  for (const brim::ContactSample& c : world.contacts())
    std::printf("%d %d  %g N\n", c.part_a, c.part_b, double(c.force.norm()));
  return 0;
}

brim::World made_by_hand() {
  brim::World world;
  brim::ObstacleModel floor;
  floor.shape = brim::make_half_space();
  floor.part.voxel_size = 0.05;
  auto ground = std::make_unique<brim::ObstacleBody>(floor);
  ground->set_name("floor");
  world.add(std::move(ground));

  brim::RigidModel crate = brim::make_rigid(brim::make_box({0.4, 0.3, 0.2}), 600.0);
  crate.part.material.friction = 0.4;
  for (int i = 0; i < 3; ++i) {
    crate.position = brim::Vec3(0.0, 0.0, 0.1 + 0.25 * i);
    auto body = std::make_unique<brim::RigidBody>(crate);
    body->set_name("crate." + std::to_string(i));
    world.add(std::move(body));
  }
  return world;
}

brim::WorldOptions game_options() {
  brim::WorldOptions options;
  options.response = brim::Response::Constraint;
  options.constraint_tolerance = 1e-3;
  options.constraint_sweeps = 60;
  options.sleep = true;
  return options;
}

int spawn(brim::World& world, brim::SolidStore& solids, int number, const brim::Vec3& at) {
  const std::string text = fmt::format(
      R"({{"brim": 1, "name": "spawn", "duration": 1, "bodies": [{{"kind": "rigid", "name": "gear{}",
           "shape": {{"kind": "star", "points": 5, "outer": 0.2, "inner": 0.1, "thickness": 0.05}},
           "transform": {{"position": [{}, {}, {}]}}}}]}})",
      number, at.x(), at.y(), at.z());
  int last = -1;
  for (auto& body : brim::build_bodies(brim::parse_scene(text), solids)) last = world.add(std::move(body));
  return last;
}

void keep_the_newest(brim::World& world, std::deque<int>& live, std::size_t most) {
  for (; live.size() > most; live.pop_front()) world.remove(live.front());
}

void lift_by_a_joint(brim::World& world, const std::string& body, const brim::Vec3& place) {
  brim::Attachment rail;
  rail.name = body + " rail", rail.body = body;
  brim::LinkJoint fixed;
  fixed.kind = brim::JointKind::Fixed, fixed.position = place;
  rail.joint = fixed;
  rail.motion = [](double time, const brim::Vec3& x, const brim::Vec3&) {
    return brim::Vec3(x + brim::Vec3(0.0, 0.0, 0.5 * (1.0 - std::cos(time))));
  };
  world.attach(rail);
}

void follow_path(brim::World& world, int platform) {
  const double t = world.state().time + world.options().time_step;  // where it shall be after the step
  const brim::Vec3 place(1.0 - std::cos(t), 0.0, 0.0);
  world.set_target(platform, {brim::Mat3::Identity(), place});
  world.step();
}

void save(const brim::World& world, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  const brim::State& state = world.state();
  const auto put = [&](const auto* data, std::size_t n) {
    file.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(n * sizeof *data));
  };
  put(&state.time, 1), put(&state.step, 1);
  for (const std::vector<double>* list : {&state.q, &state.v, &state.warm_start}) {
    const std::uint64_t n = list->size();
    put(&n, 1), put(list->data(), list->size());
  }
}

void load(brim::World& world, const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  brim::State state;
  const auto get = [&](auto* data, std::size_t n) {
    file.read(reinterpret_cast<char*>(data), static_cast<std::streamsize>(n * sizeof *data));
    if (!file) throw brim::InputError(path + ": the file is too short");
  };
  get(&state.time, 1), get(&state.step, 1);
  for (std::vector<double>* list : {&state.q, &state.v, &state.warm_start}) {
    std::uint64_t n = 0;
    get(&n, 1);
    if (n > (std::uint64_t{1} << 32)) throw brim::InputError(path + ": is no saved state");
    list->resize(n);
    get(list->data(), list->size());
  }
  world.set_state(std::move(state));
}

bool on_ground(const brim::World& world, int robot) {
  const auto others = [robot](int body) { return body != robot; };
  const brim::Vec3 foot(world.q(robot)[0], world.q(robot)[1], world.q(robot)[2]);
  const auto below = world.raycast(foot, -brim::Vec3::UnitZ(), 0.12, others);
  return below && below->normal.z() > 0.7;  // no steeper than 45 degrees
}

std::vector<std::string> words_of(std::istream& text) {
  std::vector<std::string> all;
  for (std::string word; text >> word;) all.push_back(word);
  return all;
}

/// Without spaces, where lines may be broken.
std::string dense(const std::string& text) {
  std::istringstream in(text);
  std::string all;
  for (const std::string& word : words_of(in)) all += word;
  return all;
}

std::string read(const std::string& path) {
  std::ifstream file(path);
  std::stringstream all;
  all << file.rdbuf();
  return all.str();
}

TEST(CppPage, ItsCodeIsThatOfThisFile) {
  const std::string page = read(BRIM_SOURCE_DIR "/docs/cpp.md"),
                    here = dense(read(BRIM_SOURCE_DIR "/tests/scene/cpp_page_test.cpp"));
  int blocks = 0;
  for (std::size_t at = 0; (at = page.find("```cpp\n", at)) != std::string::npos; ++blocks) {
    at += 7;
    std::string block = page.substr(at, page.find("```", at) - at);
    if (block.starts_with("#include \"brim/brim.h\"")) block = block.substr(block.find('\n'));
    // clang-format may break it otherwise; spaces do not count.
    EXPECT_NE(here.find(dense(block)), std::string::npos) << block;
  }
  EXPECT_EQ(blocks, 7);
  EXPECT_THROW(step_a_scene(), InputError) << "there is no drop.json here";
}

TEST(CppPage, BodiesByHandRestWhereTheyArePut) {
  World world = made_by_hand();
  for (int s = 0; s < 60; ++s) ASSERT_TRUE(world.step().ok);
  EXPECT_NEAR(world.body(1).mass(), 600.0 * 0.4 * 0.3 * 0.2, 1e-9);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(world.q(1 + i)[2], 0.1 + 0.2 * i, 0.01);
}

TEST(CppPage, ALoopSpawnsRemovesSavesAndLoads) {
  SolidStore solids;
  const auto make = [&] {
    World world(game_options());
    for (int i = 0; i < 6; ++i) spawn(world, solids, i, Vec3(0.5 * i, 0.0, 1.0));
    return world;
  };
  World world = make();
  world.step();
  std::deque<int> live{0, 1, 2, 3, 4, 5};
  keep_the_newest(world, live, 4);
  EXPECT_TRUE(world.removed(0) && world.removed(1) && !world.removed(2));
  world.step();
  const std::string path = (std::filesystem::temp_directory_path() / "brim_cpp_page.state").string();
  save(world, path);
  World other = make();
  load(other, path);
  EXPECT_EQ(other.hash(), world.hash());
  EXPECT_TRUE(world.step().ok && other.step().ok);
  EXPECT_EQ(other.hash(), world.hash());
  std::filesystem::resize_file(path, 100);
  EXPECT_THROW(load(other, path), InputError);
  std::filesystem::remove(path);
}

TEST(CppPage, ARayTellsWhatStandsOnTheGround) {
  World world = made_by_hand();
  EXPECT_TRUE(on_ground(world, 1));
  EXPECT_FALSE(on_ground(world, 2)) << "a gap of 0.05 m above the crate below it";
  world.remove(1);
  EXPECT_FALSE(on_ground(world, 3));
}

/// A platform of 0.2 m with a crate on it.
World with_platform(double density) {
  World world(game_options());
  const auto add = [&](const char* name, RigidModel model) {
    auto body = std::make_unique<RigidBody>(std::move(model));
    body->set_name(name);
    world.add(std::move(body));
  };
  add("platform", make_rigid(make_box({2, 2, 0.2}), density));
  add("crate", make_rigid(make_box({0.3, 0.3, 0.3}), 200.0, Vec3(0, 0, 0.25)));
  return world;
}

TEST(CppPage, PlatformsCarryWhatStandsOnThem) {
  World lift = with_platform(500.0);
  lift_by_a_joint(lift, "platform", Vec3::Zero());
  for (int s = 0; s < 120; ++s) ASSERT_TRUE(lift.step().ok);
  const double up = 0.5 * (1.0 - std::cos(2.0));
  EXPECT_NEAR(lift.q(0)[2], up, 0.01);
  EXPECT_NEAR(lift.q(1)[2], up + 0.25, 0.02);

  World ferry(game_options());
  ObstacleModel deck;
  deck.shape = make_box({4, 2, 0.2});
  deck.part.voxel_size = 0.05;
  auto platform = std::make_unique<ObstacleBody>(deck);
  platform->set_name("platform");
  ferry.add(std::move(platform));
  auto crate = std::make_unique<RigidBody>(make_rigid(make_box({0.3, 0.3, 0.3}), 200.0, Vec3(0, 0, 0.25)));
  crate->set_name("crate");
  ferry.add(std::move(crate));
  for (int s = 0; s < 120; ++s) follow_path(ferry, 0);
  EXPECT_NEAR(ferry.q(0)[0], 1.0 - std::cos(2.0), 1e-9);
  EXPECT_NEAR(ferry.q(1)[0], ferry.q(0)[0], 0.05);
}

}  // namespace
}  // namespace brim::testing::cpp_page_test
