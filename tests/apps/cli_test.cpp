#include <dlfcn.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "brim/record/run_reader.h"

namespace brim::cli_test {
namespace {

namespace fs = std::filesystem;
using testing::Program;

TEST_F(Program, BadSceneEndsWithTwoOneLineAndNoFiles) {
  const Outcome o = run("run bad.json -o made");
  EXPECT_EQ(o.code, 2);
  EXPECT_TRUE(o.err.starts_with("brim: error: bad.json:1: /bodys: unknown key")) << o.err;
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  EXPECT_FALSE(fs::exists(folder_ / "made"));
}

TEST_F(Program, BadArgumentsEndWithTwo) {
  for (const char* arguments : {"", "rum good.json", "run", "run none.json", "run good.json --frames 0",
                                "run good.json --threads -1", "run good.json --frames many", "run good.json --wat",
                                "info none.obj", "info out.txt", "validate none.json", "run good.json --resume none"}) {
    const Outcome o = run(arguments);
    EXPECT_EQ(o.code, 2) << arguments;
    EXPECT_TRUE(o.err.starts_with("brim: error: ")) << arguments << ": " << o.err;
  }
}

TEST_F(Program, PairsTellsHowEachDoesAndFailsWithOne) {
  const std::string table = R"({"brim": 1, "drop": {"steps": 30}, "bounds": {"overlap": BOUND},
    "world": {"gravity": [0, 0, 0], "time_step": 0.005, "voxel_size": 0.02, "max_substeps": 1, "friction_speed": 1e-4},
    "kinds": [{"name": "ball", "lowest": -0.1, "highest": 0.1,
               "body": {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}}}]})";
  std::string loose = table, tight = table;
  write("loose.json", loose.replace(loose.find("BOUND"), 5, "1"));
  write("tight.json", tight.replace(tight.find("BOUND"), 5, "1e-6"));
  const Outcome good = run("pairs --kinds loose.json -o made/pairs.md --scenes made");
  EXPECT_EQ(good.code, 0) << good.err << good.out;
  EXPECT_NE(read(folder_ / "made/pairs.md").find("**1 of 1 pairs are good**"), std::string::npos);
  EXPECT_EQ(run("validate made/ball_on_ball.json").code, 0);
  // Figures that were kept are taken over, wall times among them.
  EXPECT_EQ(run("pairs --kinds loose.json -o made/page.md --resume made/kept.jsonl").code, 0);
  const std::string page = read(folder_ / "made/page.md"), kept = read(folder_ / "made/kept.jsonl");
  EXPECT_EQ(run("pairs --kinds loose.json -o made/page.md --resume made/kept.jsonl").code, 0);
  EXPECT_EQ(read(folder_ / "made/page.md"), page);
  EXPECT_EQ(read(folder_ / "made/kept.jsonl"), kept);
  EXPECT_EQ(run("pairs --kinds loose.json --resume loose.json").code, 2);
  const Outcome bad = run("pairs --kinds tight.json --json");
  EXPECT_EQ(bad.code, 1);
  EXPECT_FALSE(nlohmann::json::parse(bad.out).at("pairs").at(0).at("ok").get<bool>());
  EXPECT_EQ(run("pairs --kinds loose.json --only bell").code, 2);
  EXPECT_EQ(run("pairs --kinds none.json").code, 2);
}

TEST_F(Program, APluginBringsItsKindToEveryCommand) {
  const std::string plugin = " --plugin '" + std::string(BRIM_BINARY_DIR) + "/examples/jelly.so'";
  write("jelly.json", R"({"brim": 1, "name": "jelly", "frames": 2, "bodies": [
    {"kind": "jelly", "name": "ball", "radius": 0.2}]})");
  EXPECT_EQ(run("run jelly.json -o made").code, 2) << "nobody knows the kind";
  EXPECT_EQ(run("run jelly.json -o made" + plugin).code, 0);
  EXPECT_EQ(run("info made").code, 0);
  EXPECT_EQ(run("validate jelly.json --plugin none.so").code, 2);
  EXPECT_EQ(run("validate jelly.json" + plugin + plugin).code, 0) << "twice is once";
}

TEST_F(Program, ALibraryThatIsNoPluginIsRefusedInOneLine) {
  Dl_info libc{};
  ASSERT_NE(::dladdr(reinterpret_cast<const void*>(&std::getenv), &libc), 0);
  const Outcome o = run(std::string("validate good.json --plugin '") + libc.dli_fname + "'");
  EXPECT_EQ(o.code, 2);
  EXPECT_EQ(o.err.find(std::string("brim: error: --plugin ") + libc.dli_fname + ": is no plugin of brim"), 0u) << o.err;
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
}

TEST_F(Program, ValidateWarnsOfTimelineEntriesThatTheRunDoesNotGetTo) {
  std::string text = good(0.0);
  text.insert(text.find("\"bodies\""), R"("timeline": [{"at": 0.04, "freeze": "ball"}, {"at": 0.05, "thaw": "ball"}],)"
                                       "\n");
  write("late.json", text);
  const Outcome o = run("validate late.json");
  EXPECT_EQ(o.code, 0);
  EXPECT_EQ(o.err.find("brim: warning: late.json:1: /timeline/1/at: 0.05 s"), 0u) << o.err;
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
}

TEST_F(Program, ResumeTakesTheRunsFileForItsFolder) {
  ASSERT_EQ(run("run good.json -o made").code, 0);
  const Outcome o = run("run --resume made/run.h5 --frames 8");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(RunReader((folder_ / "made").string()).frames(), 9);
  const std::string there = "cd '" + (folder_ / "made").string() + "' && '" + std::string(BRIM_BINARY_DIR) + "/brim'";
  EXPECT_EQ(std::system((there + " run --resume run.h5 --frames 9 > /dev/null 2>&1").c_str()), 0);
  EXPECT_EQ(RunReader((folder_ / "made").string()).frames(), 10);
}

TEST_F(Program, RenderSaysAtOnceWhatTheRunDoesNotHave) {
  ASSERT_EQ(run("run good.json -o made").code, 0);
  for (const auto& [option, words] :
       {std::pair{"--surface bal",
                  "--surface bal: \"bal\" is not a body of the run, which has floor, ball; did you mean \"ball\"?"},
        {"--slice y=0,bal",
         "--slice y=0,bal: \"bal\" is not a body of the run, which has floor, ball; did you mean \"ball\"?"},
        {"--colour bal=#ffffff",
         "--colour bal=#ffffff: \"bal\" is not a body of the run, which has floor, ball; did you mean \"ball\"?"},
        {"--surface ball", "--surface ball: \"ball\" is not made of particles"}}) {
    const Outcome o = run(std::string("render made -o a.png ") + option);
    EXPECT_EQ(o.code, 2) << option;
    EXPECT_EQ(o.err.find(std::string("brim: error: ") + words), 0u) << o.err;
  }
  fs::remove(folder_ / "made/scene.json");
  EXPECT_NE(run("render made -o a.png --slice y").err.find("keeps no scene.json"), std::string::npos);
  // Names that are there pass: what is missing then are the programs that draw.
  ::setenv("BRIM_CHROMIUM", "/none", 1);
  const Outcome good = run("render made -o a.png --colour ball=#ffffff");
  ::unsetenv("BRIM_CHROMIUM");
  EXPECT_EQ(good.err.find("is not a body"), std::string::npos) << good.err;
  EXPECT_EQ(good.err.find("brim: error: brim render"), 0u) << good.err;
}

TEST_F(Program, GoodSceneIsRecordedAndChecked) {
  const Outcome o = run("run good.json -o made --check --threads 1");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("position_z of ball"), std::string::npos) << o.out;
  for (const char* name : {"run.h5", "run.xdmf", "summary.json", "scene.json"})
    EXPECT_TRUE(fs::exists(folder_ / "made" / name)) << name;
  EXPECT_EQ(run("info made").code, 0);
  EXPECT_EQ(run("run good.json -o made").code, 2) << "an old run is not replaced without --force";
  EXPECT_EQ(run("run good.json -o made --force --frames 2").code, 0);
  EXPECT_EQ(RunReader((folder_ / "made").string()).frames(), 3);
  const Outcome resumed = run("run good.json --resume made");
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_EQ(RunReader((folder_ / "made").string()).frames(), 6);
}

TEST_F(Program, ResumeAloneTakesTheSceneThatTheRunKeeps) {
  // A file beside the scene, and a parameter that was set: both come from the run.
  fs::create_directories(folder_ / "scenes");
  write("scenes/cube.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\n"
        "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  write("scenes/set.json", R"({"brim": 1, "name": "set", "frames": 6, "parameters": {"z": 3},
    "bodies": [{"kind": "rigid", "name": "cube", "shape": {"kind": "mesh", "file": "cube.obj"},
                "transform": {"position": [0, 0, "=z"]}}]})");
  ASSERT_EQ(run("run scenes/set.json --set z=2 -o straight").code, 0);
  ASSERT_EQ(run("run scenes/set.json --set z=2 -o parts --frames 2").code, 0);
  const Outcome o = run("run --resume parts");
  ASSERT_EQ(o.code, 0) << o.err;
  const RunReader a((folder_ / "straight").string()), b((folder_ / "parts").string());
  ASSERT_EQ(b.frames(), 7);
  EXPECT_EQ(a.state(6).q, b.state(6).q);
  // Without a run, or a scene in it, it is said what is missing.
  const Outcome none = run("run --resume nowhere"), nothing = run("run");
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.err.find("nowhere"), std::string::npos) << none.err;
  EXPECT_EQ(nothing.code, 2);
  EXPECT_NE(nothing.err.find("--resume"), std::string::npos) << nothing.err;
  fs::remove(folder_ / "parts/scene.json");
  const Outcome lost = run("run --resume parts --frames 9");
  EXPECT_EQ(lost.code, 2);
  EXPECT_NE(lost.err.find("parts/scene.json"), std::string::npos) << lost.err;
}

TEST_F(Program, ProfileTellsPhasesKindsAndCounts) {
  const Outcome o = run("run good.json -o made --profile --threads 1");
  ASSERT_EQ(o.code, 0) << o.err;
  for (const char* word :
       {"rasterize", "contact, all of it", "by kind of body", "rigid", "thread-s", "substeps", "a solve"})
    EXPECT_NE(o.out.find(word), std::string::npos) << word << " in\n" << o.out;
}

TEST_F(Program, CheckEndsWithOneWhenAnExpectationIsNotMet) {
  write("high.json", good(99.0));
  const Outcome o = run("run high.json -o made --check");
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.out.find("FAIL"), std::string::npos) << o.out;
  EXPECT_EQ(run("run high.json -o other").code, 0) << "without --check a bound is only reported";
}

TEST_F(Program, WithoutACheckNoRunFailsByEndingEarlyOrByHoldingWhatIsKnownToBeMissed) {
  std::string text = good(0.0);
  const std::string bound = R"("expect": [)";
  text.insert(
      text.find(bound) + bound.size(),
      R"({"metric": "substeps", "to": 0.02, "min": 1, "known_miss": "none"}, {"metric": "max_speed", "from": 0.04, "max": 9}, )");
  write("marked.json", text);
  const Outcome plain = run("run marked.json -o plain --frames 2"),
                checked = run("run marked.json -o checked --frames 2 --check");
  EXPECT_EQ(plain.out.find("FAIL"), std::string::npos) << plain.out;
  EXPECT_NE(plain.out.find("open  max_speed"), std::string::npos) << plain.out;
  EXPECT_NE(plain.out.find("holds in this run"), std::string::npos) << plain.out;
  EXPECT_EQ(checked.code, 1);
  EXPECT_NE(checked.out.find("FAIL  substeps"), std::string::npos) << checked.out;
  EXPECT_NE(checked.out.find("FAIL  max_speed"), std::string::npos) << checked.out;
}

TEST_F(Program, JsonLinesAreOnePerFrame) {
  const Outcome o = run("run good.json -o made --json");
  ASSERT_EQ(o.code, 0) << o.err;
  std::istringstream lines(o.out);
  std::vector<nlohmann::json> events;
  for (std::string line; std::getline(lines, line);) events.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(events.size(), 7u);
  EXPECT_EQ(events.front()["event"], "start");
  EXPECT_EQ(events[3]["frame"], 3);
  EXPECT_EQ(events.back()["end"], "completed");
}

TEST_F(Program, InterruptKeepsAllFramesAndEndsWith130) {
  start_long_run();
  ASSERT_TRUE(wait_for_frame(3));
  const int status = end(SIGINT);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  const auto summary = nlohmann::json::parse(read(folder_ / "made/summary.json"));
  EXPECT_EQ(summary["end"], "interrupted");
  const RunReader reader((folder_ / "made").string());
  EXPECT_GE(reader.frames(), 4);
  EXPECT_EQ(summary["frames"], reader.frames());
}

TEST_F(Program, InterruptEndsTheRunWithinAFrameThatTakesLong) {
  std::string text = good(0.0);
  text.insert(text.find("\"frames\""), "\"steps_per_frame\": 100000, ");
  write("good.json", text);
  start_long_run();
  ASSERT_TRUE(comes_true([&] { return fs::exists(folder_ / "made/run.h5"); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const int status = end(SIGTERM);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  const auto summary = nlohmann::json::parse(read(folder_ / "made/summary.json"));
  EXPECT_EQ(summary["end"], "interrupted");
  EXPECT_EQ(summary["frames"], 1) << "the frame that was not ended is none";
  EXPECT_EQ(RunReader((folder_ / "made").string()).frames(), 1);
}

TEST_F(Program, ARunThatIsBeingWrittenIsLeftAlone) {
  start_long_run();
  ASSERT_TRUE(wait_for_frame(3));
  const Outcome resumed = run("run good.json --resume made"), replaced = run("run good.json -o made --force");
  EXPECT_EQ(resumed.code, 2);
  EXPECT_NE(resumed.err.find("another process"), std::string::npos) << resumed.err;
  EXPECT_EQ(replaced.code, 2);
  EXPECT_EQ(::waitpid(child_, nullptr, WNOHANG), 0) << "it goes on";
  end(SIGKILL);
  const auto frames = RunReader((folder_ / "made").string()).frames();
  EXPECT_GE(frames, 1);
  const Outcome freed = run(fmt::format("run good.json --resume made --frames {}", frames + 1));
  EXPECT_EQ(freed.code, 0) << "the lock died with it; " << freed.err;
}

TEST_F(Program, ScenesWithoutEndAndWithControlCharactersEndInOnePlainLine) {
  EXPECT_EQ(run("validate /dev/zero").code, 2);
  write("odd.json", "{\"brim\": 1, \"\x1b[31m" + std::string(20000, 'k') + "\": 1}");
  const Outcome o = run("validate odd.json");
  EXPECT_EQ(o.code, 2);
  EXPECT_LT(o.err.size(), 3000u);
  EXPECT_EQ(o.err.find('\x1b'), std::string::npos);
  // Volumes, and what a NRRD header names.
  write("far.nhdr",
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nline skip: 3\ndata file: /dev/zero\n");
  fs::create_symlink("/dev/zero", folder_ / "endless.nrrd");
  for (const char* name : {"endless.nrrd", "far.nhdr"}) {
    const Outcome v = run(std::string("info ") + name);
    EXPECT_EQ(v.code, 2) << name;
    EXPECT_NE(v.err.find("not a file"), std::string::npos) << v.err;
  }
}

TEST_F(Program, AFullDiskEndsTheRunWithOneLine) {
  // [kB] that a file may have: full while the first tables are written, while they are flushed, and among the frames.
  for (const int room : {0, 2, 4, 8, 16, 40, 200}) {
#ifdef __SANITIZE_THREAD__
    if (room == 0) continue;  // the sanitizer writes a file of its own before the program begins
#endif
    SCOPED_TRACE(room);
    const std::string command = fmt::format(
        "cd '{}' && (ulimit -f {}; '{}/brim' run good.json -o full --force --frames 2000 2>&1 >/dev/null) | cat "
        ">err.txt; exit ${{PIPESTATUS[0]}}",
        folder_.string(), room, BRIM_BINARY_DIR);
    write("full.sh", command);
    const int status = std::system(fmt::format("bash '{}'", (folder_ / "full.sh").string()).c_str());
    ASSERT_TRUE(WIFEXITED(status)) << "a signal ended it";
    EXPECT_EQ(WEXITSTATUS(status), 2);
    const std::string said = read(folder_ / "err.txt");
    EXPECT_NE(said.find("disk full"), std::string::npos) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
  }
}

TEST_F(Program, AFrameThatIsNotThereCannotBeRendered) {
  ASSERT_EQ(run("run good.json -o made --frames 2").code, 0);
  EXPECT_EQ(run("render made -o a.png --frame 3").code, 2);
  EXPECT_EQ(run("render made -o a.png --frame -4").code, 2);
}

TEST_F(Program, PlotDrawsARunAndRefusesInOneLine) {
  ASSERT_EQ(run("run good.json -o made --frames 3").code, 0);
  for (const char* wrong : {"plot made -o a.pdf", "plot none", "plot made -o a.svg extra"}) {
    const Outcome o = run(wrong);
    EXPECT_EQ(o.code, 2) << wrong;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  }
  // A program that says that it has no Matplotlib, as plot_run.py does.
  write("bare", "#!/bin/sh\nexit 3\n");
  fs::permissions(folder_ / "bare", fs::perms::owner_all);
  ASSERT_EQ(setenv("BRIM_PYTHON", (folder_ / "bare").c_str(), 1), 0);
  const Outcome bare = run("plot made");
  unsetenv("BRIM_PYTHON");
  EXPECT_EQ(bare.code, 2);
  EXPECT_NE(bare.err.find("python3-matplotlib"), std::string::npos) << bare.err;
  EXPECT_FALSE(fs::exists(folder_ / "made/plot.svg"));
  const Outcome drawn = run("plot made");
  if (drawn.err.find("python3-matplotlib") != std::string::npos) GTEST_SKIP() << "no Matplotlib";
  ASSERT_EQ(drawn.code, 0) << drawn.err;
  EXPECT_NE(read(folder_ / "made/plot.svg").find("</svg>"), std::string::npos);
  EXPECT_EQ(run("plot made/run.h5 -o a.png").code, 0);
  EXPECT_TRUE(fs::exists(folder_ / "a.png"));
}

TEST_F(Program, KilledRunKeepsTheFramesFlushedBeforeAndCanBeGoneOnWith) {
  start_long_run();
  ASSERT_TRUE(wait_for_frame(3));
  const auto look = [&] {
    const RunReader run((folder_ / "made").string());
    const std::int64_t last = run.frames() - 1;
    for (const std::int64_t f : {std::int64_t{0}, last / 2, last}) {
      EXPECT_NEAR(run.state(f).time, 0.01 * static_cast<double>(f), 1e-6);
      EXPECT_EQ(run.positions(1, f).size(), run.bodies()[1].display.vertices);
      run.contacts(f);
    }
    return run.frames();
  };
  // A reader that looks in the middle of a flush may get an error and looks again (docs/formats.md).
  EXPECT_TRUE(comes_true([&] {
    try {
      return look() >= 4;
    } catch (const InputError&) {
      return false;
    }
  })) << "frames can be read while the writer lives";
  end(SIGKILL);
  const std::int64_t frames = look();
  EXPECT_GE(frames, 4);
  const Outcome resumed = run("run good.json --resume made --frames " + std::to_string(frames + 2));
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_EQ(RunReader((folder_ / "made").string()).frames(), frames + 3);
}

TEST_F(Program, ARunKilledBeforeItsFirstFrameStartsOver) {
  // Its file made and nothing written yet, and only numbers without the head that says what they are.
  for (const std::string& left : {std::string(), std::string(4096, '\0')}) {
    fs::remove_all(folder_ / "made");
    fs::create_directories(folder_ / "made");
    write("made/run.h5", left);
    const Outcome o = run("run good.json --resume made --frames 2");
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_NE(o.err.find("made from its start"), std::string::npos) << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_EQ(RunReader((folder_ / "made").string()).frames(), 3);
  }
  // What is no run at all is not replaced.
  write("made/run.h5", "a letter");
  EXPECT_EQ(run("run good.json --resume made --frames 2").code, 2);
  EXPECT_EQ(read(folder_ / "made/run.h5"), "a letter");
}

TEST_F(Program, RenderSaysWhatMustLieInAFolderOfOnesOwnPage) {
  run("run good.json --frames 1 -o made");
  fs::create_directories(folder_ / "page");
  write("page/index.html", "the page");
  ::setenv("BRIM_VIEWER_DIR", (folder_ / "page").c_str(), 1);
  ::setenv("BRIM_CHROMIUM", "/bin/true", 1);
  const Outcome o = run("render made -o a.png");
  ::unsetenv("BRIM_CHROMIUM");
  ::unsetenv("BRIM_VIEWER_DIR");
  EXPECT_EQ(o.code, 2);
  if (o.err.find("needs Node") != std::string::npos) GTEST_SKIP() << "Node is not installed";
  EXPECT_NE(o.err.find("/page, where render.mjs is missing; pictures need it, viewer/render.mjs of brim's sources, "
                       "beside index.html or in the folder above"),
            std::string::npos)
      << o.err;
}

TEST_F(Program, ViewServesTheRunWhileItIsMadeAndCtrlCEndsBoth) {
  fs::create_directories(folder_ / "page");
  write("page/index.html", "the page");
  child_ = ::fork();
  if (child_ == 0) {
    ::setenv("BRIM_VIEWER_DIR", (folder_ / "page").c_str(), 1);
    const std::string command = "cd '" + folder_.string() + "' && exec '" + std::string(BRIM_BINARY_DIR) +
                                "/brim' run good.json --frames 1000000 -o made --view > out.txt 2> err.txt";
    ::execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  int port = 0;
  ASSERT_TRUE(comes_true([&] {
    const std::string out = read(folder_ / "out.txt");
    const std::size_t at = out.find("http://127.0.0.1:");
    if (at == std::string::npos || out.find('/', at + 17) == std::string::npos) return false;
    port = std::atoi(out.c_str() + at + 17);
    return true;
  })) << read(folder_ / "err.txt");
  EXPECT_TRUE(comes_true([&] {
    const std::string answer = testing::http_ask(port, "/api/run");
    const std::size_t body = answer.find("\r\n\r\n");
    if (body == std::string::npos) return false;
    const auto info = nlohmann::json::parse(answer.substr(body), nullptr, false);
    if (!info.is_object() || !info.contains("frames")) return false;  // caught in the middle of a write
    EXPECT_EQ(info["complete"], false);
    return info["frames"] >= 3;
  })) << "frames appear while the run goes on";
  const int status = end(SIGINT);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(nlohmann::json::parse(read(folder_ / "made/summary.json"))["end"], "interrupted");
  EXPECT_EQ(testing::http_ask(port, "/api/run"), "") << "the server has ended with the run";
}

TEST_F(Program, ExportWritesARunAndRefusesInOneLine) {
  ASSERT_EQ(run("run good.json -o made").code, 0);
  const Outcome o = run("export made --format ply --frames 1:3");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_TRUE(fs::exists(folder_ / "made/export/ply/ball_00003.ply"));
  for (const char* arguments : {"export made --format ply", "export made --format doc -o x", "export made",
                                "export made --format obj -o x --frames 9", "export none --format obj -o x",
                                "export made --format obj -o x --bodies bell"}) {
    const Outcome bad = run(arguments);
    EXPECT_EQ(bad.code, 2) << arguments;
    EXPECT_EQ(std::count(bad.err.begin(), bad.err.end(), '\n'), 1) << bad.err;
  }
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

TEST_F(Program, OutputThatDoesNotArriveIsAFailure) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  EXPECT_EQ(run("schema > /dev/full; exit $?; true").code, 1);
  EXPECT_EQ(run("info good.json > /dev/full; exit $?; true").code, 1);
  EXPECT_EQ(run("--help > /dev/full; exit $?; true").code, 1);
}

TEST_F(Program, SchemaIsPrintedAndAccepted) {
  const Outcome o = run("schema");
  EXPECT_EQ(o.code, 0);
  EXPECT_EQ(nlohmann::json::parse(o.out)["title"], "brim scene");
  EXPECT_EQ(run("validate good.json").code, 0);
  EXPECT_EQ(run("validate bad.json").code, 2);
  EXPECT_EQ(run("info good.json").code, 0);
}

}  // namespace
}  // namespace brim::cli_test
