#include "server/recorded_run.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "brim/core/error.h"
#include "brim/record/h5.h"
#include "brim/record/runner.h"
#include "brim/scene/scene.h"
#include "brim/world/report_fields.h"
#include "support/removing_run.h"

namespace brim::viewer::recorded_run_test {
namespace {

namespace fs = std::filesystem;
using h5::Type;

/// One array of a message, read without the code under test (docs/viewer.md gives the layout).
struct Array {
  std::uint32_t type = 0, rows = 0, columns = 0;
  std::vector<double> values;
};

template <class T>
T number_at(const std::string& m, std::size_t at) {
  T x;
  std::memcpy(&x, m.data() + at, sizeof x);
  return x;
}

/// Arrays by name, with the body's number after a colon for those that belong to one.
std::map<std::string, Array> decode(const std::string& m) {
  std::map<std::string, Array> arrays;
  for (std::uint32_t i = 0; i < number_at<std::uint32_t>(m, 8); ++i) {
    const std::size_t at = 16 + 56 * i;
    Array a{number_at<std::uint32_t>(m, at + 32),
            number_at<std::uint32_t>(m, at + 40),
            number_at<std::uint32_t>(m, at + 44),
            {}};
    const auto offset = number_at<std::uint64_t>(m, at + 48);
    for (std::size_t k = 0; k < std::size_t{a.rows} * a.columns; ++k)
      a.values.push_back(a.type == 1   ? number_at<float>(m, offset + 4 * k)
                         : a.type == 2 ? number_at<std::int32_t>(m, offset + 4 * k)
                                       : number_at<double>(m, offset + 8 * k));
    const auto body = number_at<std::int32_t>(m, at + 36);
    arrays[(m.c_str() + at) + (body < 0 ? std::string() : fmt::format(":{}", body))] = a;
  }
  return arrays;
}

/// Writes a run by hand, as docs/formats.md describes it: a floor that never moves and two grains that rise by a metre
/// a frame; in each odd frame one contact, one tile and a warning.
void write_run(const fs::path& folder, int frames) {
  fs::create_directories(folder);
  h5::File file((folder / "run.h5").string(), h5::File::Mode::Create);
  file.attribute("/", "format", std::string("brim-run"));
  file.attribute("/", "version", std::int64_t{1});
  file.attribute("/", "brim_version", std::string("0.1.0"));
  file.attribute("/", "scene", std::string("by hand"));
  file.attribute("/", "frame_time", 0.1);
  file.attribute("/", "steps_per_frame", std::int64_t{1});
  for (const char* g :
       {"/bodies", "/parts", "/frames", "/display", "/series", "/contacts", "/tiles", "/pairs", "/memory", "/warnings"})
    file.group(g);
  const auto body = [&](int b, const char* name, const char* display, int vertices, bool immobile) {
    const std::string at = "/bodies/" + std::to_string(b);
    file.group(at);
    file.attribute(at, "name", std::string(name));
    file.attribute(at, "kind", std::string("made"));
    file.attribute(at, "display_kind", std::string(display));
    for (const char* zero : {"two_sided", "q_offset", "q_size", "v_offset", "v_size"})
      file.attribute(at, zero, std::int64_t{0});
    file.attribute(at, "radius", 0.25);
    file.attribute(at, "vertices", std::int64_t{vertices});
    file.attribute(at, "immobile", std::int64_t{immobile});
    file.attribute(at, "mass", 1.0);
    file.attribute(at, "parts", std::int64_t{1});
    const std::string part = "/parts/" + std::to_string(b);
    file.group(part);
    file.attribute(part, "name", std::string(name));
    file.attribute(part, "material", std::string("m"));
    file.attribute(part, "body", std::int64_t{b});
    file.attribute(part, "part", std::int64_t{0});
    file.attribute(part, "voxel_size", 0.1);
    file.group("/display/" + std::to_string(b));
  };
  body(0, "floor", "triangles", 3, true);
  body(1, "grains", "points", 2, false);
  const std::int32_t triangle[] = {0, 1, 2};
  file.write("/bodies/0/triangles", Type::Int32, std::vector<std::uint64_t>{1, 3}, triangle);

  const std::vector<std::uint64_t> scalar, three = {3}, two = {2};
  const auto grow = [&](const std::string& path, Type type, const std::vector<std::uint64_t>& row) {
    return file.growing(path, type, row, 4, 0);
  };
  auto floor = grow("/display/0/positions", Type::Float32, {3, 3});
  const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  floor.append(corners, 1, Type::Float32);
  auto grains = grow("/display/1/positions", Type::Float32, {2, 3});
  auto time = grow("/frames/time", Type::Float64, scalar), v = grow("/frames/v", Type::Float64, {1});
  std::vector<h5::Dataset> series;
  for (const ReportField& f : report_fields())
    series.push_back(grow(std::string("/series/") + f.name, Type::Float64, scalar));
  std::map<std::string, h5::Dataset> offset;
  const std::int64_t zero = 0;
  for (const char* g : {"/contacts", "/tiles", "/pairs", "/memory", "/warnings"})
    (offset[g] = grow(std::string(g) + "/offset", Type::Int64, scalar)).append(&zero, 1, Type::Int64);
  auto position = grow("/contacts/position", Type::Float32, three),
       force = grow("/contacts/force", Type::Float32, three);
  auto friction = grow("/contacts/friction", Type::Float32, three),
       overlap = grow("/contacts/overlap", Type::Float32, scalar);
  auto pair = grow("/contacts/pair", Type::Int32, two), key = grow("/tiles/key", Type::Int32, three);
  auto step = grow("/tiles/step", Type::Float64, scalar), text = grow("/warnings/text", Type::UInt8, scalar);
  std::int64_t rows = 0, letters = 0;
  for (int f = 0; f < frames; ++f) {
    const double t = 0.1 * f, nothing = 0.0, h = 0.5;
    const auto z = static_cast<float>(f);
    const float p[] = {0, 0, z, 1, 0, z};
    time.append(&t, 1, Type::Float64);
    v.append(&nothing, 1, Type::Float64);
    grains.append(p, 1, Type::Float32);
    for (std::size_t k = 0; k < series.size(); ++k) {
      const double x = 100.0 * static_cast<double>(k) + f;
      series[k].append(&x, 1, Type::Float64);
    }
    if (f % 2 == 1) {
      const float at[] = {0.1f, 0.2f, z}, push[] = {0, 0, 9}, drag[] = {1, 0, 0}, deep = 0.75f;
      const std::int32_t between[] = {0, 1}, tile[] = {-1, 0, f};
      position.append(at, 1, Type::Float32);
      force.append(push, 1, Type::Float32);
      friction.append(drag, 1, Type::Float32);
      overlap.append(&deep, 1, Type::Float32);
      pair.append(between, 1, Type::Int32);
      key.append(tile, 1, Type::Int32);
      step.append(&h, 1, Type::Float64);
      const std::string line = fmt::format("{{\"time\":{},\"code\":\"saturation\",\"message\":\"deep\"}}\n", t);
      text.append(line.data(), line.size(), Type::UInt8);
      ++rows;
      letters += static_cast<std::int64_t>(line.size());
    }
    for (const char* g : {"/contacts", "/tiles"}) offset[g].append(&rows, 1, Type::Int64);
    for (const char* g : {"/pairs", "/memory"}) offset[g].append(&zero, 1, Type::Int64);
    offset["/warnings"].append(&letters, 1, Type::Int64);
  }
}

/// [s] of the slowest frame.
double slowest_wall(const fs::path& folder) {
  double slowest = 0.0;
  for (const double x : RunReader(folder.string()).series("wall")) slowest = std::max(slowest, x);
  return slowest;
}

class RecordedRunTest : public ::testing::Test {
 protected:
  fs::path folder_ = fs::temp_directory_path() / fmt::format("brim_recorded_{}", getpid());
  ~RecordedRunTest() override { fs::remove_all(folder_); }
};

TEST_F(RecordedRunTest, AFrameHoldsWhatWasWritten) {
  write_run(folder_, 3);
  RecordedRun run(folder_.string());
  const auto a = decode(run.frame(1));
  EXPECT_EQ(a.at("time").values, std::vector<double>{0.1});
  EXPECT_EQ(a.count("positions:0"), 0u);
  EXPECT_EQ(a.at("positions:1").values, (std::vector<double>{0, 0, 1, 1, 0, 1}));
  EXPECT_EQ(a.at("contacts/force").values, (std::vector<double>{0, 0, 9}));
  EXPECT_EQ(a.at("contacts/friction").values, (std::vector<double>{1, 0, 0}));
  EXPECT_EQ(a.at("contacts/overlap").values, std::vector<double>{0.75});
  EXPECT_EQ(a.at("contacts/pair").values, (std::vector<double>{0, 1}));
  EXPECT_EQ(a.at("tiles/key").values, (std::vector<double>{-1, 0, 1}));
  EXPECT_EQ(a.at("tiles/step").values, std::vector<double>{0.5});
  EXPECT_EQ(decode(run.frame(2)).at("contacts/position").rows, 0u);
}

TEST_F(RecordedRunTest, InfoTopologyAndSeriesTellOfTheRun) {
  write_run(folder_, 3);
  RecordedRun run((folder_ / "run.h5").string());
  const auto info = run.info();
  EXPECT_EQ(info["frames"], 3);
  EXPECT_EQ(info["complete"], false);
  EXPECT_EQ(info["bodies"][0]["fixed"], true);
  EXPECT_EQ(info["bodies"][1]["display"], "points");
  EXPECT_EQ(info["bodies"][1]["parts"], nlohmann::json::array({1}));
  EXPECT_EQ(info["parts"][1]["name"], "grains");
  ASSERT_EQ(info["warnings"].size(), 1u);
  EXPECT_EQ(info["warnings"][0]["code"], "saturation");
  const auto floor = decode(run.topology(0));
  EXPECT_EQ(floor.at("triangles:0").values, (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(floor.at("positions:0").values, (std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0}));
  const auto series = decode(run.series(1));
  EXPECT_EQ(series.at("time").values, (std::vector<double>{0.1, 0.2}));
  EXPECT_EQ(series.at(report_fields()[2].name).values, (std::vector<double>{201, 202}));
  EXPECT_EQ(decode(run.series(99)).at("time").rows, 0u);
}

TEST_F(RecordedRunTest, SlicesAreThoseOfTheRunThatIsThereNow) {
  const auto record = [&](double radius, const char* started) {
    const Scene scene = parse_scene(fmt::format(
        R"({{"brim": 1, "name": "a", "frames": 1, "bodies": [{{"kind": "rigid", "name": "ball",
           "shape": {{"kind": "sphere", "radius": {}}}}}]}})",
        radius));
    World world = build_world(scene);
    RunPlan plan;
    plan.folder = folder_.string();
    plan.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
    plan.frames = plan.scene_frames = scene.frames;
    plan.force = true;
    record_run(world, plan, {});
    h5::File((folder_ / "run.h5").string(), h5::File::Mode::Write)
        .attribute("/", "writer_started", std::string(started));  // as by a process of its own
  };
  SliceRequest request;
  request.step = 0.05;
  record(0.5, "first");
  RecordedRun run(folder_.string());
  const auto wide = decode(run.slice(0, request)).at("nodes").values;
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  record(0.25, "second");
  EXPECT_NE(decode(run.slice(0, request)).at("nodes").values, wide);
}

// A bar held at its ends and pulled by a hundredth: E times that, everywhere on its surface.
TEST_F(RecordedRunTest, StressIsThatOfTheElasticSolidsAtTheFrame) {
  const Scene scene = parse_scene(R"({"brim": 1, "name": "a", "frames": 1, "world": {"gravity": [0, 0, 0]},
    "bodies": [{"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.1}},
    {"kind": "finite_elements", "name": "bar", "shape": {"kind": "box", "size": [0.4, 0.2, 0.2]}, "lattice_spacing": 0.1,
     "young_modulus": 1e5, "poisson_ratio": 0, "transform": {"position": [2, 0, 0]}}]})");
  World world = build_world(scene);
  State state = world.state();
  std::vector<double> q(world.q(1).begin(), world.q(1).end());
  for (std::size_t i = 0; i < q.size(); i += 3) q[i] = 2.0 + 1.01 * (q[i] - 2.0);
  std::copy(q.begin(), q.end(), state.q.end() - static_cast<std::ptrdiff_t>(q.size()));
  world.set_state(state);
  RunPlan plan;
  plan.folder = folder_.string();
  plan.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
  plan.frames = plan.scene_frames = scene.frames;
  record_run(world, plan, {});
  const auto stress = decode(RecordedRun(folder_.string()).stress(0));
  ASSERT_EQ(stress.size(), 1u);
  const auto& values = stress.at("von_mises:1").values;
  EXPECT_EQ(values.size(), world.body(1).display().vertices);
  for (const double s : values) EXPECT_NEAR(s, 1e3, 1.0);
}

TEST_F(RecordedRunTest, SlicesThatManyAskForAtOnceAreRefusedBeyondThree) {
  const Scene scene = parse_scene(R"({"brim": 1, "name": "a", "frames": 1, "world": {"voxel_size": 1e-3},
    "bodies": [{"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.5}}]})");
  World world = build_world(scene);
  RunPlan plan;
  plan.folder = folder_.string();
  plan.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
  plan.frames = plan.scene_frames = scene.frames;
  record_run(world, plan, {});
  RecordedRun run(folder_.string());
  std::atomic<int> made = 0, refused = 0;
  const auto ask = [&] {
    try {
      run.slice(0, SliceRequest{});
      ++made;
    } catch (const Busy&) {
      ++refused;
    }
  };
  {
    std::vector<std::jthread> askers;
    for (int i = 0; i < 12; ++i) askers.emplace_back(ask);
  }
  EXPECT_EQ(made + refused, 12);
  EXPECT_GE(made, 3);
  EXPECT_GE(refused, 1);
  ask();
  EXPECT_EQ(made + refused, 13);
  EXPECT_GE(made, 4) << "who was refused leaves no trace";
}

TEST_F(RecordedRunTest, AGrowingRunIsNoticedAndItsSummaryEndsIt) {
  write_run(folder_, 2);
  RecordedRun run(folder_.string());
  EXPECT_EQ(run.progress(), (Progress{2, false}));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  // The same file with more in it, as another process that writes would leave it.
  write_run(folder_ / "longer", 5);
  fs::copy_file(folder_ / "longer/run.h5", folder_ / "run.h5", fs::copy_options::overwrite_existing);
  EXPECT_EQ(run.progress(), (Progress{5, false}));
  EXPECT_EQ(decode(run.frame(4)).at("positions:1").values[2], 4.0);
  EXPECT_EQ(run.info()["warnings"].size(), 2u);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  std::ofstream(folder_ / "summary.json") << "{\"frames\": 5}";
  EXPECT_EQ(run.progress(), (Progress{5, true}));
  EXPECT_FALSE(run.progress().stopped);
  EXPECT_EQ(run.info()["summary"]["frames"], 5);
}

TEST_F(RecordedRunTest, ASummaryOfAllFramesEndsTheRunWhicheverFileIsYounger) {
  write_run(folder_, 3);
  std::ofstream(folder_ / "summary.json") << "{\"frames\": 3}";
  fs::last_write_time(folder_ / "summary.json", fs::file_time_type::clock::now() - std::chrono::minutes(1));
  EXPECT_EQ(RecordedRun(folder_.string()).progress(), (Progress{3, true, false})) << "as after going on with a run";
  std::ofstream(folder_ / "summary.json") << "{\"frames\": 2}";
  EXPECT_EQ(RecordedRun(folder_.string()).progress(), (Progress{3, false, false})) << "it is gone on with";
}

TEST_F(RecordedRunTest, APipeInThePlaceOfARunIsRefused) {
  fs::create_directories(folder_);
  ASSERT_EQ(::mkfifo((folder_ / "run.h5").c_str(), 0600), 0);
  EXPECT_THROW(RecordedRun(folder_.string()), InputError);
}

TEST_F(RecordedRunTest, PipesInThePlaceOfWhatLiesBesideARunAreNotWaitedFor) {
  write_run(folder_, 2);
  for (const char* name : {"run.h5.journal", "summary.json", "scene.json"}) {
    fs::remove(folder_ / name);
    ASSERT_EQ(::mkfifo((folder_ / name).c_str(), 0600), 0);
  }
  RecordedRun run(folder_.string());
  EXPECT_EQ(run.progress().frames, 2);
  EXPECT_EQ(run.info()["frames"], 2);
  EXPECT_THROW(run.slice(0, SliceRequest{}), InputError);
}

TEST_F(RecordedRunTest, ARunWhoseWriterIsGoneDoesNotGrowForEver) {
  write_run(folder_, 2);
  const auto mark = [&](const ProcessMark& m) {
    h5::File file((folder_ / "run.h5").string(), h5::File::Mode::Write);
    file.attribute("/", "writer_pid", m.pid);
    file.attribute("/", "writer_host", m.host);
    file.attribute("/", "writer_started", m.started);
  };
  ProcessMark mine = this_process();
  mark(mine);
  EXPECT_EQ(RecordedRun(folder_.string()).progress(), (Progress{2, false, false})) << "its writer lives";
  mine.started += "0";  // the number went to another process since
  mark(mine);
  EXPECT_EQ(RecordedRun(folder_.string()).progress(), (Progress{2, true, true}));
  EXPECT_EQ(RecordedRun(folder_.string()).info()["stopped"], true);
  // Another machine's: only silence tells.
  mine.host += ".elsewhere";
  mark(mine);
  EXPECT_EQ(RecordedRun(folder_.string()).progress(), (Progress{2, false, false}));
  fs::last_write_time(folder_ / "run.h5", fs::file_time_type::clock::now() - std::chrono::hours(1));
  // Its slowest frame took 20 s: an hour without a word is long.
  EXPECT_EQ(RecordedRun(folder_.string()).progress().stopped, RecordedRun(folder_.string()).progress().complete);
  EXPECT_TRUE(RecordedRun(folder_.string()).progress().stopped || slowest_wall(folder_) * 20 > 3600);
}

TEST_F(RecordedRunTest, ARunWithoutFramesAndACutFileAreSurvived) {
  write_run(folder_, 0);
  RecordedRun run(folder_.string());
  EXPECT_EQ(run.progress().frames, 0);
  EXPECT_NO_THROW(run.info());
  EXPECT_NO_THROW(run.topology(0));
  EXPECT_EQ(decode(run.series(0)).at("time").rows, 0u);
  EXPECT_THROW(run.frame(0), InputError);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  fs::resize_file(folder_ / "run.h5", 100);
  EXPECT_EQ(run.progress().frames, 0);
  EXPECT_THROW(run.info(), InputError);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  write_run(folder_ / "whole", 2);
  fs::copy_file(folder_ / "whole/run.h5", folder_ / "run.h5", fs::copy_options::overwrite_existing);
  EXPECT_EQ(run.progress().frames, 2);
}

TEST_F(RecordedRunTest, WhatIsNotThereIsAnInputError) {
  EXPECT_THROW(RecordedRun((folder_ / "none").string()), InputError);
  write_run(folder_, 1);
  RecordedRun run(folder_.string());
  EXPECT_THROW(run.frame(1), InputError);
  EXPECT_THROW(run.frame(-1), InputError);
  EXPECT_THROW(run.topology(2), InputError);
  EXPECT_THROW(run.topology(-1), InputError);
}

TEST(RecordedRunEdits, AFrameNamesTheBodiesThatWereRemovedAndHasNoPositionsOfThem) {
  const testing::RemovingRun made;
  RecordedRun run(made.folder());
  auto arrays = decode(run.frame(testing::RemovingRun::kGone - 1));
  EXPECT_TRUE(arrays.at("removed").values.empty());
  for (int b = 1; b <= 8; ++b) EXPECT_TRUE(arrays.contains(fmt::format("positions:{}", b))) << b;
  arrays = decode(run.frame(testing::RemovingRun::kGone));
  EXPECT_EQ(arrays.at("removed").values, (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8}));
  for (int b = 1; b <= 8; ++b) EXPECT_FALSE(arrays.contains(fmt::format("positions:{}", b))) << b;
}

}  // namespace
}  // namespace brim::viewer::recorded_run_test
