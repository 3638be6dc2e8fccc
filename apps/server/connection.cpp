#include "server/connection.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace brim::viewer {

namespace {

constexpr std::chrono::milliseconds kPatience{5000};  // for a head to come, and for an answer to begin to go
constexpr std::chrono::milliseconds kForever{1000L * 3600 * 24 * 365};
constexpr std::size_t kLeastPace = 64;                     // [bytes/ms] at which an answer is taken
constexpr std::size_t kMostBehind = std::size_t{1} << 16;  // [bytes] of events that a reader has not taken

}  // namespace

Connection::Connection(int socket, std::uint64_t number) : socket_(socket), number_(number) {
  set(State::Reading, kPatience);
}

Connection::~Connection() { ::close(socket_); }

void Connection::set(State state, std::chrono::milliseconds time) {
  state_ = state;
  since_ = Clock::now();
  deadline_ = since_ + time;
}

short Connection::wanted() const {
  switch (state_) {
    case State::Reading:
      return POLLIN;
    case State::Answering:
      return 0;
    case State::Sending:
      return POLLOUT;
    case State::Streaming:
      return static_cast<short>(POLLIN | (waiting() > 0 ? POLLOUT : 0));
  }
  return 0;
}

bool Connection::receive() {
  char room[4096];
  const ssize_t n = ::recv(socket_, room, sizeof room, 0);
  if (n < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
  if (n == 0) return false;
  // Who listens to events has nothing more to say.
  if (state_ == State::Reading) in_.append(room, static_cast<std::size_t>(n));
  return true;
}

std::optional<HttpRequest> Connection::take_request() {
  if (state_ != State::Reading) return {};
  const auto size = head_size(in_);
  if (!size && in_.size() <= kMostHead) return {};
  keep_ = head_only_ = false;
  if (!size || *size > kMostHead) {
    answer(HttpResponse::error(431, "the request is too long"));
    return {};
  }
  std::optional<HttpRequest> request = parse_request(std::string_view(in_).substr(0, *size));
  in_.erase(0, *size);
  if (!request) {
    answer(HttpResponse::error(400, "that is no request"));
    return {};
  }
  head_only_ = request->method == "HEAD";
  keep_ = request->keep_alive && !request->has_body;
  set(State::Answering, kForever);
  return request;
}

void Connection::answer(const HttpResponse& response) {
  keep_ = keep_ && response.status < 400;
  out_ = bytes_of(response, head_only_, keep_);
  sent_ = 0;
  if (response.events && !head_only_)
    set(State::Streaming, kForever);
  else
    set(State::Sending, kPatience + std::chrono::milliseconds(out_.size() / kLeastPace));
}

bool Connection::tell(const std::string& text) {
  out_.erase(0, sent_);
  sent_ = 0;
  out_ += text;
  return out_.size() <= kMostBehind;
}

bool Connection::send() {
  while (waiting() > 0) {
    const ssize_t n = ::send(socket_, out_.data() + sent_, waiting(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return true;
    if (n <= 0) return false;
    sent_ += static_cast<std::size_t>(n);
    since_ = Clock::now();
  }
  if (state_ != State::Sending) return true;
  out_.clear(), out_.shrink_to_fit();
  sent_ = 0;
  if (!keep_) {
    // The other side reads to the end; what it still sends is not waited for.
    ::shutdown(socket_, SHUT_WR);
    return false;
  }
  set(State::Reading, kPatience);
  return true;
}

}  // namespace brim::viewer
