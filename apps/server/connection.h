#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "server/http_message.h"

namespace brim::viewer {

/// One connection of the server: what has come and what is to go. Its socket never blocks.
class Connection {
 public:
  using Clock = std::chrono::steady_clock;
  enum class State { Reading, Answering, Sending, Streaming };

  /// @param socket  non-blocking; closed with the connection
  Connection(int socket, std::uint64_t number);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  int socket() const { return socket_; }
  std::uint64_t number() const { return number_; }
  State state() const { return state_; }
  /// When it is given up, unless something comes or goes before.
  Clock::time_point deadline() const { return deadline_; }
  Clock::time_point since() const { return since_; }           ///< when its state changed, or something went
  std::size_t waiting() const { return out_.size() - sent_; }  ///< [bytes] to go
  short wanted() const;                                        ///< events of poll

  /// Takes what has come. @return false when the connection is over
  bool receive();
  /// The next request, when it is whole; the connection waits for its answer then. What is no request is answered here.
  std::optional<HttpRequest> take_request();
  void answer(const HttpResponse& response);
  /// Something new for a stream. @return false when its reader has fallen too far behind
  bool tell(const std::string& text);
  /// Sends what can be sent now. @return false when the connection is over
  bool send();

 private:
  void set(State state, std::chrono::milliseconds time);

  int socket_;
  std::uint64_t number_;
  State state_ = State::Reading;
  Clock::time_point since_, deadline_;
  std::string in_, out_;
  std::size_t sent_ = 0;
  bool head_only_ = false, keep_ = true;
};

}  // namespace brim::viewer
