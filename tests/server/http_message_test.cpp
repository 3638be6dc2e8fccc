#include "server/http_message.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace brim::viewer::http_message_test {
namespace {

TEST(HttpMessage, ARequestIsReadWhole) {
  const std::string text =
      "GET /api/slice/3?axis=1&at=-0.5&name=a%20b+c HTTP/1.1\r\nHost: localhost:80\r\nX-Odd:  b c \r\n\r\nnext";
  ASSERT_EQ(head_size(text), text.size() - 4);
  const auto r = parse_request(text.substr(0, text.size() - 4));
  ASSERT_TRUE(r);
  EXPECT_EQ(r->method, "GET");
  EXPECT_EQ(r->path, "/api/slice/3");
  EXPECT_EQ(r->query.at("at"), "-0.5");
  EXPECT_EQ(r->query.at("name"), "a b c");
  EXPECT_EQ(r->header_or("host"), "localhost:80");
  EXPECT_EQ(r->header_or("x-odd"), "b c");
  EXPECT_TRUE(r->keep_alive);
  EXPECT_FALSE(r->has_body);
}

TEST(HttpMessage, WhatHasNoBlankLineIsNotThereYet) {
  const std::string whole = "GET / HTTP/1.1\r\nHost: a\r\n\r\n";
  for (std::size_t n = 0; n < whole.size(); ++n) EXPECT_FALSE(head_size(whole.substr(0, n))) << n;
  EXPECT_EQ(head_size(whole), whole.size());
  EXPECT_EQ(head_size("GET / HTTP/1.0\n\nx"), 16u);
}

TEST(HttpMessage, WhatIsNoRequestIsNotTakenForOne) {
  for (const char* bad :
       {"", "\r\n\r\n", "GET\r\n\r\n", "GET /\r\n\r\n", "GET / HTTP/2.0\r\n\r\n", "get / HTTP/1.1\r\n\r\n",
        "GET a HTTP/1.1\r\n\r\n", "GET /%zz HTTP/1.1\r\n\r\n", "GET /%2 HTTP/1.1\r\n\r\n", "GET /%00 HTTP/1.1\r\n\r\n",
        "GET /a b HTTP/1.1\r\n\r\n", "GET / HTTP/1.1\r\nno colon\r\n\r\n", "GET / HTTP/1.1\r\n: x\r\n\r\n",
        "GET / HTTP/1.1\r\n folded: x\r\n\r\n", "GET /?a=%0a HTTP/1.1\r\n\r\n"})
    EXPECT_FALSE(parse_request(bad)) << bad;
}

TEST(HttpMessage, BodiesAndTheEndOfAConnectionAreSeen) {
  const auto with = [](const std::string& fields, const char* version = "1.1") {
    return *parse_request(std::string("POST / HTTP/") + version + "\r\n" + fields + "\r\n");
  };
  EXPECT_TRUE(with("Content-Length: 1\r\n").has_body);
  EXPECT_TRUE(with("content-length: x\r\n").has_body);
  EXPECT_TRUE(with("Transfer-Encoding: chunked\r\n").has_body);
  EXPECT_FALSE(with("Content-Length: 0\r\n").has_body);
  EXPECT_FALSE(with("Connection: Close\r\n").keep_alive);
  EXPECT_FALSE(with("", "1.0").keep_alive);
  EXPECT_TRUE(with("Connection: Keep-Alive\r\n", "1.0").keep_alive);
}

TEST(HttpMessage, AnAnswerSaysHowLongItIsAndAHeadIsSentAlone) {
  const HttpResponse r{200, "text/plain", "four"};
  const std::string whole = bytes_of(r, false, true), head = bytes_of(r, true, false);
  EXPECT_TRUE(whole.starts_with("HTTP/1.1 200 OK\r\n"));
  EXPECT_NE(whole.find("Content-Length: 4\r\n"), std::string::npos);
  EXPECT_TRUE(whole.ends_with("keep-alive\r\n\r\nfour"));
  EXPECT_TRUE(head.ends_with("Connection: close\r\n\r\n"));
  EXPECT_EQ(nlohmann::json::parse(HttpResponse::error(404, "no \xff").body)["error"], "no \xef\xbf\xbd");
}

TEST(HttpMessage, HostsAreReadWithoutTheirPorts) {
  EXPECT_EQ(host_name("localhost:80"), "localhost");
  EXPECT_EQ(host_name("[::1]:80"), "[::1]");
  EXPECT_EQ(origin_host("http://a.example:80"), "a.example");
  EXPECT_EQ(origin_host("null"), "");
}

}  // namespace
}  // namespace brim::viewer::http_message_test
