#pragma once

#include <filesystem>
#include <functional>

#include "server/http_message.h"
#include "server/run_source.h"

namespace brim::viewer {

/// What is answered to each request: the page's files and the data of a run (docs/viewer.md). Nothing else on the disk
/// can be reached. With someone to tell, a page may also take hold of bodies. Safe to call from several threads. Tests:
/// tests/server/viewer_server_test.cpp, tests/fuzz
class ViewerRoutes {
 public:
  ViewerRoutes(RunSource& source, std::filesystem::path page) : source_(source), page_(std::move(page)) {}

  /// Requests that name another host than this machine are refused, or taken.
  void answer_any_host(bool any) { any_host_ = any; }
  /// Takes what a page asks for of the bodies of the run, one object of JSON each: {"grab": body, "vertex": its nearest
  /// vertex, "offset": [m] from there}, {"pull": [m]}, {"release": true}. False where it cannot be taken now.
  using Tell = std::function<bool(const std::string&)>;
  void pass_on(Tell tell) { tell_ = std::move(tell); }
  HttpResponse answer(const HttpRequest& request) const;

 private:
  HttpResponse data(const HttpRequest& request) const;
  HttpResponse file(const std::string& path) const;
  HttpResponse hand(const HttpRequest& request) const;

  RunSource& source_;
  std::filesystem::path page_;
  bool any_host_ = false;
  Tell tell_;
};

bool is_loopback(const std::string& host);

}  // namespace brim::viewer
