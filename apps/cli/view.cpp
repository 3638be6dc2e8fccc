#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "brim/core/error.h"
#include "commands.h"
#include "server/page_folder.h"
#include "server/recorded_run.h"
#include "server/viewer_server.h"

namespace brim::cli {

namespace {

constexpr int kUsualPort = 8420;

struct ViewOptions {
  std::string run;
  std::string host = "127.0.0.1";
  int port = -1;  ///< -1: the usual one, or any other if that is taken
  int with = 0;   ///< process whose end is this one's too
  int hand = -1;  ///< socket to it, for what pages ask of the bodies; -1: none
};

std::function<bool(const std::string&)> tell_by(int socket) {
  if (socket < 0) return {};
  return [socket](const std::string& asked) {
    return ::send(socket, asked.data(), asked.size(), MSG_DONTWAIT | MSG_NOSIGNAL) ==
           static_cast<ssize_t>(asked.size());
  };
}

int take_port(viewer::ViewerServer& server, const ViewOptions& options) {
  if (options.port >= 0) return server.bind(options.host, options.port);
  try {
    return server.bind(options.host, kUsualPort);
  } catch (const InputError&) {
    return server.bind(options.host, 0);
  }
}

int view(const ViewOptions& options) {
  viewer::RecordedRun run(options.run);
  viewer::ViewerServer server(run, viewer::find_page_folder(), tell_by(options.hand));
  const int port = take_port(server, options);
  watch_interrupts();  // before others are told that they may end it
  const bool v6 = options.host.find(':') != std::string::npos;
  fmt::print("{} is shown at http://{}:{}/  (Ctrl-C ends)\n", options.run,
             v6 ? fmt::format("[{}]", options.host) : options.host, port);
  std::fflush(stdout);
  std::jthread serving([&server] { server.listen(); });
  const auto alone = [&options] { return options.with > 0 && ::getppid() != options.with; };
  while (!interrupted() && !alone()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  server.stop();
  return kGood;
}

}  // namespace

void add_view(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("view", "show a run, finished or growing, in a browser");
  auto options = std::make_shared<ViewOptions>();
  command->add_option("run", options->run, "run folder, or its run.h5")->required();
  command->add_option("--port", options->port, "port to listen on, 0 for any; without it 8420, or any if that is taken")
      ->check(CLI::Range(0, 65535));
  command
      ->add_option("--host", options->host,
                   "address to listen on; any but this machine's own lets others on the network read the run")
      ->capture_default_str();
  command->add_option("--with", options->with)->group("");  // both for `brim run --view`
  command->add_option("--hand", options->hand)->group("");
  command->callback([options, &code] { code = view(*options); });
}

}  // namespace brim::cli
