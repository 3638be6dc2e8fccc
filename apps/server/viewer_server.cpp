#include "server/viewer_server.h"

#include <httplib.h>

#include <atomic>
#include <charconv>
#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "brim/core/error.h"

namespace brim::viewer {

using Json = nlohmann::json;

namespace {

constexpr auto kPoll = std::chrono::milliseconds(300);
constexpr int kQuietPolls = 30;             // a comment is sent after so many, to notice pages that have gone
constexpr std::size_t kThreads = 48;        // each open page holds one for its events
constexpr int kMostStreams = 16;            // of events: the other threads are kept for answers
constexpr int kPatience = 5;                // [s] for a page to send what it asks, or to take what it gets
constexpr std::size_t kMostPayload = 4096;  // [bytes]; no request needs any
constexpr std::size_t kMostAddress = 2048;  // [bytes]

void answer_json(httplib::Response& response, int status, const Json& value) {
  response.status = status;
  response.set_content(value.dump(-1, ' ', false, Json::error_handler_t::replace), "application/json");
}

void refuse(httplib::Response& response, int status, const std::string& why) {
  answer_json(response, status, {{"error", why}});
}

/// The host of a Host header, without its port.
std::string host_name(const std::string& header) {
  if (header.starts_with('[')) return header.substr(0, header.find(']') + 1);
  return header.substr(0, header.find(':'));
}

bool is_loopback(const std::string& host) {
  return host == "127.0.0.1" || host == "localhost" || host == "::1" || host == "[::1]";
}

std::int64_t number(const std::string& text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw InputError(fmt::format("\"{}\" is not a number that can be used here", text));
  return value;
}

int index(std::int64_t value) {
  if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max())
    throw InputError(fmt::format("{} is not a number that can be used here", value));
  return static_cast<int>(value);
}

/// The host that an Origin header names, "" for one that names none ("null").
std::string origin_host(const std::string& origin) {
  const std::size_t scheme = origin.find("://");
  return scheme == std::string::npos ? std::string() : host_name(origin.substr(scheme + 3));
}

double real(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw InputError(fmt::format("\"{}\" is not a number that can be used here", text));
  return value;
}

}  // namespace

struct ViewerServer::Impl {
  RunSource& source;
  httplib::Server http;
  std::atomic<bool> stopping = false;
  std::atomic<int> streams = 0;
  bool loopback_only = true;

  explicit Impl(RunSource& s) : source(s) {}

  template <class Answer>
  void get(const char* path, Answer answer) {
    http.Get(path, [answer](const httplib::Request& request, httplib::Response& response) {
      response.set_header("Cache-Control", "no-store");
      try {
        answer(request, response);
      } catch (const InputError& error) {
        refuse(response, 404, error.what());
      } catch (const std::exception& error) {
        refuse(response, 500, error.what());
      }
    });
  }

  void events(httplib::Response& response) {
    if (++streams > kMostStreams) {
      --streams;
      return refuse(response, 503, "too many pages are open at once");
    }
    auto told = std::make_shared<Progress>();
    auto quiet = std::make_shared<int>(-1);  // nothing told yet
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, told, quiet](std::size_t, httplib::DataSink& to) {
          if (stopping) return false;
          Progress now = *told;
          try {
            now = source.progress();
          } catch (const std::exception&) {
            // The file is gone for the moment; the page goes on with what it has.
          }
          if (*quiet < 0 || !(now == *told)) {
            *quiet = 0;
            *told = now;
            const std::string text =
                fmt::format("event: frames\ndata: {{\"frames\":{},\"complete\":{},\"stopped\":{}}}\n\n", now.frames,
                            now.complete, now.stopped);
            return to.write(text.data(), text.size());
          }
          if (++*quiet >= kQuietPolls) {
            *quiet = 0;
            return to.write(": still here\n\n", 14);
          }
          std::this_thread::sleep_for(kPoll);
          return true;
        },
        [this](bool) { --streams; });
  }

  void routes(const std::filesystem::path& page) {
    const auto binary = [](httplib::Response& response, std::string body) {
      response.set_content(std::move(body), "application/octet-stream");
    };
    get("/api/run", [this](const auto&, auto& response) { answer_json(response, 200, source.info()); });
    get(R"(/api/topology/(\d+))", [this, binary](const auto& request, auto& response) {
      binary(response, source.topology(index(number(request.matches[1]))));
    });
    get(R"(/api/frame/(\d+))", [this, binary](const auto& request, auto& response) {
      binary(response, source.frame(number(request.matches[1])));
    });
    get("/api/series", [this, binary](const auto& request, auto& response) {
      binary(response, source.series(request.has_param("from") ? number(request.get_param_value("from")) : 0));
    });
    get("/api/events", [this](const auto&, auto& response) { events(response); });
    get(R"(/api/slice/(\d+))", [this, binary](const auto& request, auto& response) {
      SliceRequest slice;
      const auto given = [&](const char* name, auto fallback) {
        return request.has_param(name) ? request.get_param_value(name) : std::string(fallback);
      };
      slice.axis = index(number(given("axis", "2")));
      slice.body = index(number(given("body", "-1")));
      slice.at = real(given("at", "0"));
      slice.step = real(given("step", "0"));
      binary(response, source.slice(number(request.matches[1]), slice));
    });
    http.set_mount_point("/", page.string());
    http.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      const auto handled = [&](int status, const char* why) {
        refuse(response, status, why);
        response.set_header("Connection", "close");
        return httplib::Server::HandlerResponse::Handled;
      };
      const std::string host = host_name(request.get_header_value("Host"));
      if (loopback_only && !is_loopback(host)) return handled(403, "this server answers to localhost only");
      // Pages of other sites may send requests here, and learn from how they end.
      if (request.has_header("Origin") && origin_host(request.get_header_value("Origin")) != host)
        return handled(403, "this server answers to its own page only");
      if (request.method != "GET" && request.method != "HEAD") return handled(405, "only GET is answered");
      if (request.target.size() > kMostAddress) return handled(414, "the address is too long");
      return httplib::Server::HandlerResponse::Unhandled;
    });
    http.set_error_handler([](const httplib::Request& request, httplib::Response& response) {
      if (response.body.empty()) refuse(response, response.status, "nothing at " + request.path);
    });
    // The library's own choice would let a second server take the same port unnoticed.
    http.set_socket_options([](socket_t socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    http.set_payload_max_length(kMostPayload);
    http.set_read_timeout(kPatience);
    http.set_write_timeout(kPatience);
    http.set_keep_alive_timeout(kPatience);
    http.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    http.set_default_headers({{"X-Content-Type-Options", "nosniff"}, {"Referrer-Policy", "no-referrer"}});
  }
};

ViewerServer::ViewerServer(RunSource& source, const std::filesystem::path& page)
    : impl_(std::make_unique<Impl>(source)) {
  impl_->routes(page);
}

ViewerServer::~ViewerServer() { stop(); }

int ViewerServer::bind(const std::string& host, int port) {
  impl_->loopback_only = is_loopback(host);
  if (port == 0) {
    const int taken = impl_->http.bind_to_any_port(host);
    if (taken <= 0) throw InputError(fmt::format("no free port can be had on host {}", host));
    return taken;
  }
  if (!impl_->http.bind_to_port(host, port))
    throw InputError(
        fmt::format("port {} on host {} cannot be had; is it in use? Give another with --port", port, host));
  return port;
}

void ViewerServer::listen() { impl_->http.listen_after_bind(); }

void ViewerServer::stop() {
  impl_->stopping = true;
  impl_->http.stop();
}

}  // namespace brim::viewer
