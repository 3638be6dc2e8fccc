#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace brim::viewer {

inline constexpr std::size_t kMostHead = 8192;  ///< [bytes] of a request; none needs more

/// What a page asks: a request of HTTP/1.0 or 1.1 (RFC 9112) without a body.
struct HttpRequest {
  std::string method;
  std::string path;                           ///< decoded, without the query
  std::map<std::string, std::string> query;   ///< decoded; of keys given twice the first
  std::map<std::string, std::string> header;  ///< names in small letters; of those given twice the first
  bool has_body = false;                      ///< one follows, which nobody reads
  bool keep_alive = true;                     ///< the page wants to ask more on this connection

  std::string header_or(const char* name, const char* otherwise = "") const;
};

struct HttpResponse {
  int status = 200;
  std::string type;  ///< of the content
  std::string body;
  bool events = false;  ///< no body of its own: what follows is a stream of events

  static HttpResponse json(int status, std::string body) { return {status, "application/json", std::move(body)}; }
  static HttpResponse error(int status, const std::string& why);
};

/// Bytes of the first head in a text, its blank line included; nothing while that has not come.
std::optional<std::size_t> head_size(std::string_view text);

/// Reads a head of head_size bytes. Nothing where it is no request. Any bytes may be given.
/// Tests: tests/server/http_message_test.cpp, tests/fuzz
std::optional<HttpRequest> parse_request(std::string_view head);

/// The bytes to be sent. @param head_only  for HEAD  @param keep_alive  the connection stays
std::string bytes_of(const HttpResponse& response, bool head_only, bool keep_alive);

/// The host of a Host header, without its port; of an Origin header, "" for one that names none ("null").
std::string host_name(const std::string& header);
std::string origin_host(const std::string& origin);

}  // namespace brim::viewer
