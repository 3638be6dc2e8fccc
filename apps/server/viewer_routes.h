#pragma once

#include <filesystem>

#include "server/http_message.h"
#include "server/run_source.h"

namespace brim::viewer {

/// What is answered to each request: the page's files and the data of a run (docs/viewer.md). Nothing else on the disk
/// can be reached. Safe to call from several threads. Tests: tests/server/viewer_server_test.cpp, tests/fuzz
class ViewerRoutes {
 public:
  ViewerRoutes(RunSource& source, std::filesystem::path page) : source_(source), page_(std::move(page)) {}

  /// Requests that name another host than this machine are refused, or taken.
  void answer_any_host(bool any) { any_host_ = any; }
  HttpResponse answer(const HttpRequest& request) const;

 private:
  HttpResponse data(const HttpRequest& request) const;
  HttpResponse file(const std::string& path) const;

  RunSource& source_;
  std::filesystem::path page_;
  bool any_host_ = false;
};

bool is_loopback(const std::string& host);

}  // namespace brim::viewer
