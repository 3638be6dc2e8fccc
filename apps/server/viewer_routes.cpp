#include "server/viewer_routes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "brim/core/error.h"
#include "brim/io/regular_file.h"

namespace brim::viewer {

using Json = nlohmann::json;

namespace {

constexpr std::size_t kMostAddress = 2048;  // [bytes]

template <class T>
T number(const std::string& text) {
  T value = 0;
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

bool all_digits(const std::string& text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

const char* type_of(const std::string& path) {
  constexpr std::pair<const char*, const char*> kTypes[] = {{".html", "text/html; charset=utf-8"},
                                                            {".js", "text/javascript"},
                                                            {".css", "text/css"},
                                                            {".json", "application/json"},
                                                            {".svg", "image/svg+xml"},
                                                            {".png", "image/png"},
                                                            {".ico", "image/x-icon"},
                                                            {".woff2", "font/woff2"},
                                                            {".txt", "text/plain; charset=utf-8"},
                                                            {".wasm", "application/wasm"}};
  for (const auto& [end, type] : kTypes)
    if (path.ends_with(end)) return type;
  return "application/octet-stream";
}

/// Parts of a path between slashes are names of files and folders, none of them hidden or above.
bool stays_inside(const std::string& path) {
  return path.find('\\') == std::string::npos && path.find("/.") == std::string::npos &&
         path.find("//") == std::string::npos;
}

HttpResponse binary(std::string body) { return {200, "application/octet-stream", std::move(body)}; }

}  // namespace

bool is_loopback(const std::string& host) {
  return host == "127.0.0.1" || host == "localhost" || host == "::1" || host == "[::1]";
}

HttpResponse ViewerRoutes::answer(const HttpRequest& request) const {
  const std::string host = host_name(request.header_or("host"));
  if (!any_host_ && !is_loopback(host)) return HttpResponse::error(403, "this server answers to localhost only");
  // Pages of other sites may send requests here, and learn from how they end.
  if (request.header.contains("origin") && origin_host(request.header_or("origin")) != host)
    return HttpResponse::error(403, "this server answers to its own page only");
  const bool post = request.method == "POST" && tell_;
  if (!post && request.method != "GET" && request.method != "HEAD")
    return HttpResponse::error(405, tell_ ? "only GET and POST are answered" : "only GET is answered");
  if (request.has_body) return HttpResponse::error(413, "no request needs a body");
  if (request.path.size() > kMostAddress) return HttpResponse::error(414, "the address is too long");
  try {
    if (post) return hand(request);
    return request.path.starts_with("/api/") ? data(request) : file(request.path);
  } catch (const TooMuchWork& error) {
    return HttpResponse::error(400, error.what());
  } catch (const Busy& error) {
    return HttpResponse::error(429, error.what());
  } catch (const InputError& error) {
    return HttpResponse::error(404, error.what());
  } catch (const std::exception& error) {
    return HttpResponse::error(500, error.what());
  }
}

HttpResponse ViewerRoutes::data(const HttpRequest& request) const {
  const auto given = [&](const char* name, const char* otherwise) {
    const auto it = request.query.find(name);
    return it == request.query.end() ? std::string(otherwise) : it->second;
  };
  const std::string what = request.path.substr(std::string_view("/api/").size());
  if (what == "run") {
    Json info = source_.info();
    info["interactive"] = static_cast<bool>(tell_);
    return HttpResponse::json(200, info.dump(-1, ' ', false, Json::error_handler_t::replace));
  }
  if (what == "events") return {200, "", "", true};
  if (what == "series") return binary(source_.series(number<std::int64_t>(given("from", "0"))));
  const std::size_t slash = what.find('/');
  const std::string kind = what.substr(0, slash), which = slash == std::string::npos ? "" : what.substr(slash + 1);
  if (all_digits(which)) {
    const auto n = number<std::int64_t>(which);
    if (kind == "topology") return binary(source_.topology(index(n)));
    if (kind == "frame") return binary(source_.frame(n));
    if (kind == "stress") return binary(source_.stress(n));
    if (kind == "slice") {
      SliceRequest slice;
      slice.axis = index(number<std::int64_t>(given("axis", "2")));
      slice.body = index(number<std::int64_t>(given("body", "-1")));
      slice.at = number<double>(given("at", "0"));
      slice.step = number<double>(given("step", "0"));
      return binary(source_.slice(n, slice));
    }
  }
  return HttpResponse::error(404, "nothing at " + request.path);
}

HttpResponse ViewerRoutes::hand(const HttpRequest& request) const {
  // What acts takes no request of another page on this machine, which has another port.
  if (request.header.contains("origin") && !request.header_or("origin").ends_with("://" + request.header_or("host")))
    return HttpResponse::error(403, "this server answers to its own page only");
  const auto given = [&](const char* name) -> const std::string& {
    const auto it = request.query.find(name);
    if (it == request.query.end()) throw InputError(fmt::format("\"{}\" is missing", name));
    return it->second;
  };
  const auto place = [&] {
    Json x = Json::array();
    for (const char* axis : {"x", "y", "z"}) {
      const auto value = number<double>(given(axis));
      if (!std::isfinite(value)) throw InputError(fmt::format("\"{}\" is not a number that can be used here", axis));
      x.push_back(value);
    }
    return x;
  };
  Json asked;
  try {
    if (request.path == "/api/grab")
      asked = {{"grab", index(number<std::int64_t>(given("body")))},
               {"vertex", index(number<std::int64_t>(given("vertex")))},
               {"offset", place()}};
    else if (request.path == "/api/pull")
      asked = {{"pull", place()}};
    else if (request.path == "/api/release")
      asked = {{"release", true}};
    else
      return HttpResponse::error(404, "nothing at " + request.path);
  } catch (const InputError& error) {
    return HttpResponse::error(400, error.what());
  }
  if (!tell_(asked.dump())) return HttpResponse::error(503, "the run is busy or has ended");
  return HttpResponse::json(200, "{}");
}

HttpResponse ViewerRoutes::file(const std::string& path) const {
  const std::string name = path == "/" ? "/index.html" : path;
  if (stays_inside(name))
    if (auto bytes = read_regular_file(page_.string() + name)) return {200, type_of(name), std::move(*bytes)};
  return HttpResponse::error(404, "nothing at " + path);
}

}  // namespace brim::viewer
