#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "server/http_message.h"

namespace brim::viewer {

/// A small server of HTTP/1.1. One thread reads what comes and sends what goes, of all connections at once and without
/// waiting for any, so that slow senders, slow readers and open streams hold nobody up; a few threads make the answers.
/// Bodies are never read, heads have at most kMostHead bytes and a few seconds, an answer is taken at 64 kB/s at least.
/// Where connections are many, the one that has been silent for longest goes.
/// Tests: tests/server/http_server_test.cpp
class HttpServer {
 public:
  using Answer = std::function<HttpResponse(const HttpRequest&)>;
  /// What is new for open streams of events since the text before; the first is what a stream begins with.
  using Event = std::function<std::string()>;

  /// @param answer  called from several threads at once  @param event  called from one of its own
  HttpServer(Answer answer, Event event);
  ~HttpServer();

  /// Time between looks for news, 300 ms unless told. Before listen().
  void look_every(std::chrono::milliseconds pulse);
  /// @param port  0 for any free one  @return the port taken  @throws InputError
  int bind(const std::string& host, int port);
  /// Answers until stop(), which may come from any thread.
  void listen();
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace brim::viewer
