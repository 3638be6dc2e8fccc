#include "server/viewer_server.h"

#include <gtest/gtest.h>
#include <httplib.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "brim/core/error.h"

namespace brim::viewer::viewer_server_test {
namespace {

namespace fs = std::filesystem;

/// A run that a test can let grow or break.
class MadeUpRun : public RunSource {
 public:
  std::atomic<std::int64_t> frames = 3;
  std::atomic<bool> complete = false;

  Progress progress() override { return {frames, complete}; }
  nlohmann::json info() override { return {{"name", "made up \xff"}, {"frames", frames.load()}}; }
  std::string topology(int body) override {
    if (body > 0) throw InputError(fmt::format("no body {}", body));
    return "topology";
  }
  std::string frame(std::int64_t f) override {
    if (f >= frames) throw InputError(fmt::format("no frame {}", f));
    if (f == 2) throw std::runtime_error("the disk failed");
    return std::string("frame\0", 6) + std::to_string(f);
  }
  std::string slice(std::int64_t f, const SliceRequest& r) override {
    if (r.step == 1e-9) throw TooMuchWork("too fine");
    if (r.step == 2.0) throw Busy("not now");
    return fmt::format("slice {} {} {} {} {}", f, r.axis, r.at, r.body, r.step);
  }
  std::string stress(std::int64_t f) override {
    if (f == 1) throw Busy("not now");
    return fmt::format("stress {}", f);
  }
  std::string series(std::int64_t from) override { return "series from " + std::to_string(from); }
};

class ViewerServerTest : public ::testing::Test {
 protected:
  ViewerServerTest() {
    std::signal(SIGPIPE, SIG_IGN);  // the client does not mind a server that stops listening
    root_ = fs::temp_directory_path() / fmt::format("brim_viewer_test_{}", getpid());
    fs::create_directories(root_ / "page/assets");
    std::ofstream(root_ / "page/index.html") << "<html>the page</html>";
    std::ofstream(root_ / "page/assets/a.js") << "let a;";
    std::ofstream(root_ / "secret.txt") << "not for the web";
    begin({});
  }
  /// @param tell  takes what pages ask of the bodies
  void begin(std::function<bool(const std::string&)> tell) {
    end();
    server_ = std::make_unique<ViewerServer>(run_, root_ / "page", std::move(tell));
    port_ = server_->bind("127.0.0.1", 0);
    thread_ = std::thread([this] { server_->listen(); });
    client_ = std::make_unique<httplib::Client>("127.0.0.1", port_);
    client_->set_connection_timeout(60);
    client_->set_read_timeout(120);
    for (int i = 0; i < 5000 && !client_->Get("/api/run"); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  void end() {
    if (!server_) return;
    server_->stop();
    thread_.join();
  }
  ~ViewerServerTest() override {
    end();
    fs::remove_all(root_);
  }

  int status(const std::string& path, const httplib::Headers& headers = {}) {
    const auto answer = client_->Get(path.c_str(), headers);
    return answer ? answer->status : -1;
  }

  MadeUpRun run_;
  fs::path root_;
  std::unique_ptr<ViewerServer> server_;
  std::unique_ptr<httplib::Client> client_;
  std::thread thread_;
  int port_ = 0;
};

TEST_F(ViewerServerTest, ServesThePageAndTheRun) {
  EXPECT_EQ(client_->Get("/")->body, "<html>the page</html>");
  EXPECT_EQ(client_->Get("/assets/a.js")->get_header_value("Content-Type").substr(0, 15), "text/javascript");
  EXPECT_EQ(client_->Get("/api/topology/0")->body, "topology");
  EXPECT_EQ(client_->Get("/api/frame/1")->body, std::string("frame\0", 6) + "1");
  EXPECT_EQ(client_->Get("/api/series?from=7")->body, "series from 7");
  EXPECT_EQ(client_->Get("/api/series")->body, "series from 0");
  EXPECT_EQ(client_->Get("/api/slice/2?axis=0&at=-0.25&body=4&step=1e-2")->body, "slice 2 0 -0.25 4 0.01");
  EXPECT_EQ(client_->Get("/api/slice/2")->body, "slice 2 2 0 -1 0");
  EXPECT_EQ(client_->Get("/api/stress/2")->body, "stress 2");
  EXPECT_EQ(nlohmann::json::parse(client_->Get("/api/run")->body)["frames"], 3);
}

TEST_F(ViewerServerTest, ErrorsSayWhatIsWrongAndTheServerGoesOn) {
  const auto missing = client_->Get("/api/frame/99");
  EXPECT_EQ(missing->status, 404);
  EXPECT_EQ(nlohmann::json::parse(missing->body)["error"], "no frame 99");
  const auto failed = client_->Get("/api/frame/2");
  EXPECT_EQ(failed->status, 500);
  EXPECT_EQ(nlohmann::json::parse(failed->body)["error"], "the disk failed");
  EXPECT_EQ(status("/api/frame/99999999999999999999999"), 404);
  EXPECT_EQ(status("/api/series?from=abc"), 404);
  EXPECT_EQ(status("/api/frame/-1"), 404);
  EXPECT_EQ(status("/api/slice"), 404);
  EXPECT_EQ(status("/api/slice/1?at=high"), 404);
  EXPECT_EQ(status("/api/slice/1?axis=1.5"), 404);
  EXPECT_EQ(status("/api/slice/1?step=1e-9"), 400);
  EXPECT_EQ(status("/api/slice/1?step=2"), 429);
  EXPECT_EQ(status("/api/stress/1"), 429);
  EXPECT_EQ(status("/api/nothing"), 404);
  EXPECT_EQ(status("/api/frame/1"), 200);
}

TEST_F(ViewerServerTest, PathsOutsideThePageAreRefused) {
  for (const char* path : {"/../secret.txt", "/assets/../../secret.txt", "/%2e%2e/secret.txt", "/..%2fsecret.txt",
                           "//etc/passwd", "/assets/..\\..\\secret.txt", "/etc/passwd"}) {
    const auto answer = client_->Get(path);
    ASSERT_TRUE(answer) << path;
    EXPECT_NE(answer->status, 200) << path;
    EXPECT_EQ(answer->body.find("not for the web"), std::string::npos) << path;
  }
}

TEST_F(ViewerServerTest, RequestsUnderAnotherNameAreRefused) {
  EXPECT_EQ(status("/api/run", {{"Host", "evil.example"}}), 403);
  EXPECT_EQ(status("/", {{"Host", "127.0.0.1.evil.example:80"}}), 403);
  EXPECT_EQ(status("/api/run", {{"Host", "localhost:1234"}}), 200);
}

TEST_F(ViewerServerTest, NothingCanBeWritten) {
  EXPECT_NE(client_->Put("/index.html", "x", "text/plain")->status, 200);
  EXPECT_NE(client_->Delete("/index.html")->status, 200);
  EXPECT_EQ(client_->Get("/")->body, "<html>the page</html>");
}

TEST_F(ViewerServerTest, PagesOfOtherSitesAndBodiesAreRefused) {
  EXPECT_EQ(status("/api/run", {{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(status("/api/run", {{"Origin", "null"}}), 403);
  EXPECT_EQ(status("/api/run", {{"Origin", fmt::format("http://127.0.0.1:{}", port_)}}), 200);
  const auto sent = client_->Post("/api/run", std::string(1 << 20, 'x'), "text/plain");
  EXPECT_TRUE(!sent || sent->status >= 400);
  EXPECT_EQ(status("/api/run"), 200);
}

TEST_F(ViewerServerTest, ARunThatIsNotInteractiveTakesNoHand) {
  EXPECT_EQ(nlohmann::json::parse(client_->Get("/api/run")->body)["interactive"], false);
  EXPECT_EQ(client_->Post("/api/release")->status, 405);
}

TEST_F(ViewerServerTest, WhatAPageAsksOfBodiesIsPassedOnIfItIsOneOfThree) {
  std::vector<std::string> told;
  std::atomic<bool> busy = false;
  begin([&](const std::string& asked) {
    if (!busy) told.push_back(asked);
    return !busy;
  });
  const auto post = [&](const std::string& path, const httplib::Headers& headers = {}) {
    const auto answer = client_->Post(path.c_str(), headers, "", "");
    return answer ? answer->status : -1;
  };
  EXPECT_EQ(nlohmann::json::parse(client_->Get("/api/run")->body)["interactive"], true);
  EXPECT_EQ(post("/api/grab?body=3&vertex=17&x=0.25&y=-1e-3&z=0"), 200);
  EXPECT_EQ(post("/api/pull?x=1&y=2&z=3"), 200);
  EXPECT_EQ(post("/api/release", {{"Origin", fmt::format("http://127.0.0.1:{}", port_)}}), 200);
  ASSERT_EQ(told.size(), 3u);
  EXPECT_EQ(nlohmann::json::parse(told[0]),
            (nlohmann::json{{"grab", 3}, {"vertex", 17}, {"offset", {0.25, -1e-3, 0.0}}}));
  EXPECT_EQ(nlohmann::json::parse(told[1]), (nlohmann::json{{"pull", {1.0, 2.0, 3.0}}}));
  EXPECT_EQ(nlohmann::json::parse(told[2]), (nlohmann::json{{"release", true}}));

  for (const char* bad : {"/api/grab", "/api/grab?body=3&vertex=17&x=0&y=0", "/api/grab?body=3.5&vertex=1&x=0&y=0&z=0",
                          "/api/grab?body=99999999999&vertex=1&x=0&y=0&z=0", "/api/pull?x=inf&y=0&z=0",
                          "/api/pull?x=nan&y=0&z=0", "/api/pull?x=1&y=2&z=", "/api/pull?x=1e999&y=2&z=3"})
    EXPECT_EQ(post(bad), 400) << bad;
  EXPECT_EQ(post("/api/frame/1"), 404);
  EXPECT_EQ(post("/index.html"), 404);
  // A page of another server on this machine, of another site, and one under another name.
  EXPECT_EQ(post("/api/release", {{"Origin", "http://127.0.0.1:1"}}), 403);
  EXPECT_EQ(post("/api/release", {{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(post("/api/release", {{"Origin", "null"}}), 403);
  EXPECT_EQ(post("/api/release", {{"Host", "evil.example"}}), 403);
  const auto sent = client_->Post("/api/release", std::string(1 << 20, 'x'), "text/plain");
  EXPECT_TRUE(!sent || sent->status >= 400);
  EXPECT_EQ(told.size(), 3u);
  EXPECT_EQ(status("/api/release"), 404) << "a link or picture somewhere cannot act";
  busy = true;
  EXPECT_EQ(post("/api/release"), 503);
  busy = false;
  EXPECT_EQ(post("/api/release"), 200);
}

TEST_F(ViewerServerTest, NumbersBeyondAnIndexAreNotTakenForSmallOnes) {
  EXPECT_EQ(status("/api/topology/0"), 200);
  EXPECT_EQ(status("/api/topology/4294967296"), 404);
  EXPECT_EQ(status("/api/slice/1?axis=4294967296"), 404);
}

TEST_F(ViewerServerTest, ManyOpenPagesLeaveRoomForAnswers) {
  std::atomic<int> heard = 0, refused = 0;
  std::vector<std::thread> pages;
  for (int i = 0; i < 20; ++i)
    pages.emplace_back([&] {
      httplib::Client page("127.0.0.1", port_);
      page.set_read_timeout(120);
      bool first = true;  // a stream that is quiet for long says that it is still there
      const auto answer = page.Get(
          "/api/events",
          [&](const httplib::Response& head) {
            if (head.status != 503) return true;
            ++refused;
            return false;
          },
          [&](const char*, std::size_t) {
            heard += std::exchange(first, false) ? 1 : 0;
            return !run_.complete;
          });
    });
  for (int i = 0; i < 10000 && heard + refused < 20; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(heard, 16);
  EXPECT_EQ(refused, 4);
  EXPECT_EQ(status("/api/frame/1"), 200);
  run_.complete = true;
  for (std::thread& page : pages) page.join();
}

TEST_F(ViewerServerTest, EventsTellOfNewFrames) {
  std::string heard;
  client_->set_read_timeout(120);
  client_->Get("/api/events", [&](const char* data, std::size_t size) {
    heard.append(data, size);
    if (run_.frames == 3)
      run_.frames = 5;
    else if (run_.frames == 5 && heard.find("\"frames\":5") != std::string::npos)
      run_.complete = true;
    return heard.find("true") == std::string::npos;
  });
  EXPECT_EQ(heard,
            "event: frames\ndata: {\"frames\":3,\"complete\":false,\"stopped\":false}\n\n"
            "event: frames\ndata: {\"frames\":5,\"complete\":false,\"stopped\":false}\n\n"
            "event: frames\ndata: {\"frames\":5,\"complete\":true,\"stopped\":false}\n\n");
}

TEST_F(ViewerServerTest, APortInUseIsAnInputError) {
  ViewerServer second(run_, root_ / "page");
  EXPECT_THROW(second.bind("127.0.0.1", port_), InputError);
}

}  // namespace
}  // namespace brim::viewer::viewer_server_test
