#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <utility>

#include "checkout_paths.h"

/// The program as its users run it, in a folder of its own.
namespace brim::testing {

namespace fs = std::filesystem;

/// Runs the real program, as a user would.
class Program : public ::testing::Test {
 protected:
  struct Outcome {
    int code = -1;
    std::string out, err;
  };

  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("brim_cli_" + std::to_string(::getpid()) + "_" +
                                           ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write("good.json", good(0.2));
    write("bad.json", R"({"brim": 1, "name": "bad", "frames": 3, "bodys": []})");
  }
  void TearDown() override {
    if (child_ > 0) end(SIGKILL);
    fs::remove_all(folder_);
  }

  /// A ball that falls on a floor; the expectation holds when `highest` is above 0.
  static std::string good(double bound) {
    return R"({"brim": 1, "name": "good", "frames": 5, "world": {"time_step": 0.01}, "bodies": [
      {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
      {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.5}, "transform": {"position": [0, 0, 0.6]}}],
      "expect": [{"metric": "position_z", "body": "ball", "min": )" +
           std::to_string(bound) + "}]}";
  }
  void write(const char* name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  std::string read(const fs::path& path) const {
    std::ostringstream out;
    out << std::ifstream(path).rdbuf();
    return out.str();
  }
  Outcome run(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.string() + "' && '" + std::string(BRIM_BINARY_DIR) + "/brim' " +
                                arguments + " > out.txt 2> err.txt";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(folder_ / "out.txt"), read(folder_ / "err.txt")};
  }

  /// Asks again until the answer is yes, for as long as the slowest machine could need.
  template <class Ask>
  static bool comes_true(const Ask& ask) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(3);
    while (std::chrono::steady_clock::now() < end) {
      if (ask()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }

  /// Begins a run without end in a process of its own; what it says goes to long.txt.
  void start_long_run() {
    child_ = ::fork();
    if (child_ != 0) return;
    if (::chdir(folder_.c_str()) != 0 || !std::freopen("long.txt", "w", stdout)) ::_exit(98);
    ::execl((std::string(BRIM_BINARY_DIR) + "/brim").c_str(), "brim", "run", "good.json", "-o", "made", "--frames",
            "10000000", "--json", nullptr);
    ::_exit(99);
  }
  /// Waits for a frame of the long run to be reported: the first one is on disk then, later ones need not be.
  bool wait_for_frame(int frame) const {
    const std::string word = "\"frame\":" + std::to_string(frame) + ",";
    return comes_true([&] { return read(folder_ / "long.txt").find(word) != std::string::npos; });
  }
  /// Ends the long run. @return its status (waitpid)
  int end(int signal) {
    int status = 0;
    ::kill(child_, signal);
    ::waitpid(std::exchange(child_, 0), &status, 0);
    return status;
  }

  fs::path folder_;
  pid_t child_ = 0;  ///< the long run
};

/// What a server on this machine answers to a request without a body, or nothing.
inline std::string http_ask(int port, const std::string& path, const std::string& method = "GET") {
  const int s = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  if (::connect(s, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) {
    const std::string ask = method + " " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    if (::write(s, ask.data(), ask.size()) > 0) {
      char buffer[4096];
      for (ssize_t n; (n = ::read(s, buffer, sizeof buffer)) > 0;) answer.append(buffer, static_cast<std::size_t>(n));
    }
  }
  ::close(s);
  return answer;
}

}  // namespace brim::testing
