#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "brim/record/run_reader.h"

/// Runs whose bodies are pulled about in the viewer while they are made.
namespace brim::interactive_test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::http_ask;
using testing::Program;

class Interactive : public Program {
 protected:
  /// Begins an interactive run of good.json. @return the port of its page, 0 where there is none
  int begin(const std::string& more = "") {
    fs::create_directories(folder_ / "page");
    write("page/index.html", "the page");
    child_ = ::fork();
    if (child_ == 0) {
      ::setenv("BRIM_VIEWER_DIR", (folder_ / "page").c_str(), 1);
      const std::string command = "cd '" + folder_.string() + "' && exec '" + std::string(BRIM_BINARY_DIR) +
                                  "/brim' run good.json --interactive " + more + " > out.txt 2> err.txt";
      ::execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
      ::_exit(127);
    }
    int port = 0;
    comes_true([&] {
      const std::string out = read(folder_ / "out.txt");
      const std::size_t at = out.find("http://127.0.0.1:");
      if (at == std::string::npos || out.find('/', at + 17) == std::string::npos) return false;
      port = std::atoi(out.c_str() + at + 17);
      return true;
    });
    return port;
  }
  static Json info(int port) {
    const std::string answer = http_ask(port, "/api/run");
    const std::size_t body = answer.find("\r\n\r\n");
    return body == std::string::npos ? Json() : Json::parse(answer.substr(body), nullptr, false);
  }
  static bool ask(int port, const std::string& path) {
    return http_ask(port, path, "POST").starts_with("HTTP/1.1 200 ");
  }
  static bool has_frames(int port, std::int64_t n) {
    return comes_true([&] {
      const Json now = info(port);
      return now.is_object() && now.contains("frames") && now["frames"] >= n;
    });
  }
};

TEST_F(Interactive, ABodyIsPulledInTheViewerAndItsTimelineDoesTheSameBitForBit) {
  const int port = begin("-o made");
  ASSERT_GT(port, 0) << read(folder_ / "err.txt");
  ASSERT_TRUE(has_frames(port, 3));
  EXPECT_EQ(info(port)["interactive"], true);
  ASSERT_TRUE(ask(port, "/api/grab?body=1&vertex=0&x=0&y=0&z=0.01"));
  ASSERT_TRUE(ask(port, "/api/pull?x=0.5&y=0.25&z=1.5"));
  const std::int64_t held = info(port)["frames"];
  ASSERT_TRUE(has_frames(port, held + 60));
  ASSERT_TRUE(ask(port, "/api/release"));
  ASSERT_TRUE(ask(port, "/api/grab?body=0&vertex=0&x=0&y=0&z=0"));
  ASSERT_TRUE(has_frames(port, held + 90));
  EXPECT_EQ(WEXITSTATUS(end(SIGINT)), 130);

  const Json pulls = Json::parse(read(folder_ / "made/pulls.json"));
  ASSERT_EQ(pulls["timeline"].size(), 3u);
  EXPECT_EQ(pulls["timeline"][0]["grab"], "ball");
  EXPECT_EQ(pulls["timeline"][1]["pull"], Json({0.5, 0.25, 1.5}));
  EXPECT_EQ(pulls["timeline"][2]["release"], true);
  const RunReader made((folder_ / "made").string());
  bool told = false, up = false;
  for (std::int64_t f = 0; f < made.frames(); ++f) {
    const State state = made.state(f);
    up = up || state.q[state.q.size() - 5] > 0.8;  // of x, y, z and a quaternion
    for (const Warning& w : made.report(f).warnings)
      told = told || (w.code == "edit_refused" && w.message == "grab: 'floor' does not move");
  }
  EXPECT_TRUE(up) << "the ball was lifted";
  EXPECT_TRUE(told) << "what cannot be grabbed is a warning of the run";

  // The same again without anybody at the mouse.
  Json scene = Json::parse(read(folder_ / "good.json"));
  scene["include"] = Json::array({{{"file", "made/pulls.json"}}});
  write("again.json", scene.dump());
  const Outcome again = run("run again.json -o again --frames " + std::to_string(made.frames() - 1));
  ASSERT_EQ(again.code, 0) << again.err;
  const RunReader replayed((folder_ / "again").string());
  ASSERT_EQ(replayed.frames(), made.frames());
  for (std::int64_t f = 0; f < made.frames(); ++f) {
    ASSERT_EQ(replayed.state(f).q, made.state(f).q) << "frame " << f;
    ASSERT_EQ(replayed.state(f).v, made.state(f).v) << "frame " << f;
  }
}

TEST_F(Interactive, KeepsToTheClockAndEndsWhereItIsTold) {
  const auto start = std::chrono::steady_clock::now();
  const int port = begin("-o made --frames 100");
  ASSERT_GT(port, 0) << read(folder_ / "err.txt");
  ASSERT_TRUE(has_frames(port, 101));
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(950));  // of 1 s
  EXPECT_TRUE(comes_true([&] { return fs::exists(folder_ / "made/summary.json"); }));
  end(SIGINT);
  EXPECT_EQ(Json::parse(read(folder_ / "made/summary.json"))["end"], "completed");
  EXPECT_FALSE(fs::exists(folder_ / "made/pulls.json")) << "nobody pulled";
}

}  // namespace
}  // namespace brim::interactive_test
