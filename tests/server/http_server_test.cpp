#include "server/http_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "brim/core/error.h"

namespace brim::viewer::http_server_test {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// A plain socket: what a page that behaves badly sends.
class Wire {
 public:
  explicit Wire(int port, int room = 0) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (room > 0) ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    const timeval patience{30, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(static_cast<std::uint16_t>(port));
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    good_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&at), sizeof at) == 0;
  }
  ~Wire() { ::close(socket_); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  bool good() const { return good_; }
  bool send(const std::string& text) {
    return ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  /// All that comes until the end, or until `enough` bytes.
  std::string read(std::size_t enough = std::size_t{1} << 30) {
    std::string text;
    char part[4096];
    for (ssize_t n; text.size() < enough && (n = ::recv(socket_, part, sizeof part, 0)) > 0;)
      text.append(part, static_cast<std::size_t>(n));
    return text;
  }

 private:
  int socket_;
  bool good_ = false;
};

class HttpServerTest : public ::testing::Test {
 protected:
  HttpServerTest()
      : server_(
            [this](const HttpRequest& r) {
              ++answers_;
              if (r.path == "/large") return HttpResponse{200, "x", std::string(std::size_t{8} << 20, 'x')};
              if (r.path == "/events") return HttpResponse{200, "", "", true};
              return HttpResponse{200, "text/plain", r.method + r.path};
            },
            [this] { return "event " + std::to_string(event_.load()) + "\n"; }) {
    port_ = server_.bind("127.0.0.1", 0);
    thread_ = std::thread([this] { server_.listen(); });
  }
  ~HttpServerTest() override {
    server_.stop();
    thread_.join();
  }

  std::string get(const std::string& path) {
    Wire wire(port_);
    wire.send("GET " + path + " HTTP/1.1\r\nConnection: close\r\n\r\n");
    return wire.read();
  }
  /// Seconds until an answer.
  double wait() {
    const auto start = Clock::now();
    EXPECT_TRUE(get("/a").ends_with("GET/a"));
    return seconds_since(start);
  }

  std::atomic<int> answers_ = 0, event_ = 0;
  HttpServer server_;
  std::thread thread_;
  int port_ = 0;
};

TEST_F(HttpServerTest, AnswersRequestsOneAfterAnotherOnOneConnection) {
  Wire wire(port_);
  for (const char* path : {"/one", "/two"}) {
    wire.send("GET " + std::string(path) + " HTTP/1.1\r\n\r\n");
    std::string text;
    while (!text.ends_with(std::string("GET") + path)) {
      const std::string more = wire.read(1);
      ASSERT_FALSE(more.empty()) << text;
      text += more;
    }
  }
  wire.send("GET /a HTTP/1.1\r\n\r\nHEAD /b HTTP/1.1\r\nConnection: close\r\n\r\n");
  const std::string both = wire.read();
  EXPECT_NE(both.find("GET/a"), std::string::npos);
  EXPECT_TRUE(both.ends_with("\r\n\r\n")) << "the answer to HEAD has no body";
}

TEST_F(HttpServerTest, BodiesAndEndlessHeadsAreNotRead) {
  for (const char* head : {"POST /a HTTP/1.1\r\nContent-Length: 3000000000\r\n\r\n", "GET /a HTTP/1.1\r\nX: ", "GET /",
                           "POST /a HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n", "POST /a HTTP/1.1\r\n\r\n"}) {
    Wire wire(port_);
    wire.send(head);
    const std::string part(1 << 16, 'b');
    std::size_t taken = 0;
    while (taken < (std::size_t{64} << 20) && wire.send(part)) taken += part.size();
    EXPECT_LT(taken, std::size_t{64} << 20) << head;
  }
  EXPECT_LT(wait(), 5.0);
}

TEST_F(HttpServerTest, WhatIsNoRequestIsRefusedAndTheConnectionEnds) {
  Wire wire(port_);
  wire.send("what?\r\n\r\n");
  EXPECT_TRUE(wire.read().starts_with("HTTP/1.1 400"));
}

TEST_F(HttpServerTest, SlowSendersHoldNobodyUp) {
  std::vector<std::unique_ptr<Wire>> slow;
  for (int i = 0; i < 300; ++i) {
    slow.push_back(std::make_unique<Wire>(port_));
    ASSERT_TRUE(slow.back()->good());
    slow.back()->send("GET /slow HT");
  }
  for (int round = 0; round < 5; ++round) {
    for (const auto& wire : slow) wire->send("T");
    EXPECT_LT(wait(), 4.0);
  }
}

TEST_F(HttpServerTest, SlowReadersHoldNobodyUp) {
  std::vector<std::unique_ptr<Wire>> slow;
  for (int i = 0; i < 100; ++i) {
    slow.push_back(std::make_unique<Wire>(port_, 1024));
    slow.back()->send("GET /large HTTP/1.1\r\n\r\n");
  }
  // 800 MiB would wait to be taken; the stuck ones are given up for those who ask.
  for (int round = 0; round < 3; ++round) EXPECT_LT(wait(), 15.0);
}

TEST_F(HttpServerTest, SilentConnectionsAreClosed) {
  Wire wire(port_);
  const auto start = Clock::now();
  EXPECT_EQ(wire.read(), "");
  EXPECT_LT(seconds_since(start), 20.0);
}

TEST_F(HttpServerTest, StreamsAreToldWhatIsNewAndAreLimited) {
  std::vector<std::unique_ptr<Wire>> pages;
  int streams = 0, refused = 0;
  for (int i = 0; i < 20; ++i) {
    pages.push_back(std::make_unique<Wire>(port_));
    pages.back()->send("GET /events HTTP/1.1\r\n\r\n");
    const std::string head = pages.back()->read(1);
    streams += head.starts_with("HTTP/1.1 200"), refused += head.starts_with("HTTP/1.1 503");
  }
  EXPECT_EQ(streams, 16);
  EXPECT_EQ(refused, 4);
  event_ = 7;
  std::string heard;
  while (heard.find("event 7\n") == std::string::npos) {
    const std::string more = pages[0]->read(1);
    ASSERT_FALSE(more.empty());
    heard += more;
  }
  pages.clear();
  EXPECT_LT(wait(), 5.0);
}

TEST_F(HttpServerTest, StopsAtOnceWhateverIsOpen) {
  Wire stream(port_), silent(port_), slow(port_, 1024);
  stream.send("GET /events HTTP/1.1\r\n\r\n");
  slow.send("GET /large HTTP/1.1\r\n\r\n");
  stream.read(1);
  const auto start = Clock::now();
  server_.stop();
  stream.read();
  EXPECT_LT(seconds_since(start), 4.0);
}

TEST(HttpServerAlone, StoppedBeforeItListensItEnds) {
  HttpServer server([](const HttpRequest&) { return HttpResponse{}; }, [] { return std::string(); });
  EXPECT_GT(server.bind("127.0.0.1", 0), 0);
  server.stop();
  server.listen();
  EXPECT_THROW(server.bind("no such host.invalid", 1), InputError);
}

}  // namespace
}  // namespace brim::viewer::http_server_test
