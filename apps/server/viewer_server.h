#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "server/run_source.h"

namespace brim::viewer {

/// Serves the viewer's page and the data of one run (docs/viewer.md describes the interface). Nothing else on the disk
/// can be reached through it; nothing can be changed, unless there is someone to tell what a page asks of the bodies.
/// While it listens on this machine alone, requests that name another host are refused, so that no web page elsewhere
/// can read a run through a name of its own. Tests: tests/server/viewer_server_test.cpp
class ViewerServer {
 public:
  /// @param source  outlives the server
  /// @param page    folder of the built page
  /// @param tell    takes what a page asks of the bodies (ViewerRoutes::pass_on), from several threads at once
  ViewerServer(RunSource& source, const std::filesystem::path& page, std::function<bool(const std::string&)> tell = {});
  ~ViewerServer();

  /// Takes a port. @param port  0 for any free one  @returns the port taken
  /// @throws InputError  when it cannot be had
  int bind(const std::string& host, int port);

  /// Answers requests until stop(), which may come from any thread or from a signal handler's thread.
  void listen();
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace brim::viewer
