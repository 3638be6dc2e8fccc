#include "live_view.h"

#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>
#include <vector>

#include "brim/core/error.h"
#include "commands.h"

namespace brim::cli {

namespace {

constexpr int kHandAt = 3;  // number of its socket in the new process

}  // namespace

LiveView::LiveView(const std::string& folder, bool out_to_error, int hand) {
  std::error_code error;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe", error).string();
  if (error) throw InputError(fmt::format("the viewer cannot be started: {}", error.message()));
  std::vector<std::string> arguments = {program, "view", folder, "--with", std::to_string(::getpid())};
  if (hand >= 0) arguments.insert(arguments.end(), {"--hand", std::to_string(kHandAt)});
  std::vector<char*> argv;
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (out_to_error) posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  if (hand >= 0) posix_spawn_file_actions_adddup2(&actions, hand, kHandAt);
  const int failed = posix_spawn(&child_, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed) throw InputError(fmt::format("the viewer cannot be started: {}", std::strerror(failed)));
}

bool LiveView::alive() {
  if (child_ > 0 && ::waitpid(child_, nullptr, WNOHANG) == child_) child_ = 0;
  return child_ > 0;
}

LiveView::~LiveView() {
  if (!alive()) return;
  ::kill(child_, SIGTERM);
  ::waitpid(child_, nullptr, 0);
}

void LiveView::stay() {
  while (!interrupted() && alive()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

}  // namespace brim::cli
