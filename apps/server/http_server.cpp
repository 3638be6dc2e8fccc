#include "server/http_server.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "brim/core/error.h"
#include "server/connection.h"

namespace brim::viewer {

namespace {

constexpr std::size_t kMostConnections = 128;
constexpr std::size_t kMostStreams = 16;                      // of events
constexpr std::size_t kMostWaiting = std::size_t{256} << 20;  // [bytes] of answers that nobody has taken yet
constexpr std::size_t kThreads = 4;                           // that make answers
constexpr std::chrono::milliseconds kStuck{1000};             // without a byte taken, where others wait for room
constexpr std::chrono::milliseconds kPulse{300};              // between looks for news, and of the loop itself
constexpr std::chrono::milliseconds kQuiet{9000};             // after which a comment is sent

using Clock = Connection::Clock;

}  // namespace

struct HttpServer::Impl {
  Answer answer;
  Event event;
  int listener = -1;
  int wake[2] = {-1, -1};  // a byte for what the loop must look at
  std::atomic<bool> stopping = false;

  // The loop's alone.
  std::vector<std::unique_ptr<Connection>> connections;
  std::uint64_t numbers = 0;
  std::string told;  // to streams that are open

  // Between the loop and those who make answers and look for news.
  struct Job {
    std::uint64_t connection;
    HttpRequest request;
  };
  struct Done {
    std::uint64_t connection;
    HttpResponse response;
  };
  std::mutex mutex;
  std::condition_variable work;
  std::deque<Job> jobs;
  std::vector<Done> done;
  std::string news;
  std::chrono::milliseconds pulse = kPulse, silence{0};
  bool comment = false;
  std::size_t listeners = 0;

  void accept_all();
  bool make_room(bool sending_only = false, std::chrono::milliseconds least = {});
  std::size_t waiting();
  void serve(Connection& c, short what, std::vector<std::uint64_t>& over);
  void drop(const std::vector<std::uint64_t>& over);
  void take_results(std::vector<std::uint64_t>& over);
  void dispatch();
  void make_answers();
  void look_for_news();
  std::size_t streams() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(connections, [](const auto& c) { return c->state() == Connection::State::Streaming; }));
  }
  void poke() const {
    const char byte = 0;
    [[maybe_unused]] const auto n = ::write(wake[1], &byte, 1);
  }
  std::deque<Job> held;  // requests that wait until answers have gone
};

HttpServer::HttpServer(Answer answer, Event event) : impl_(std::make_unique<Impl>()) {
  impl_->answer = std::move(answer);
  impl_->event = std::move(event);
  if (::pipe2(impl_->wake, O_CLOEXEC | O_NONBLOCK) != 0) throw InputError("the server can have no pipe of its own");
}

HttpServer::~HttpServer() {
  stop();
  for (const int file : {impl_->listener, impl_->wake[0], impl_->wake[1]})
    if (file >= 0) ::close(file);
}

void HttpServer::look_every(std::chrono::milliseconds pulse) { impl_->pulse = pulse; }

int HttpServer::bind(const std::string& host, int port) {
  const auto refused = [&] {
    throw InputError(port == 0 ? fmt::format("no free port can be had on host {}", host)
                               : fmt::format("port {} on host {} cannot be had; is it in use? Give another with --port",
                                             port, host));
  };
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_PASSIVE;
  if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found) != 0) refused();
  for (const addrinfo* a = found; a != nullptr && impl_->listener < 0; a = a->ai_next) {
    const int socket = ::socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, a->ai_protocol);
    if (socket < 0) continue;
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (::bind(socket, a->ai_addr, a->ai_addrlen) == 0 && ::listen(socket, 128) == 0)
      impl_->listener = socket;
    else
      ::close(socket);
  }
  ::freeaddrinfo(found);
  if (impl_->listener < 0) refused();
  sockaddr_storage taken{};
  socklen_t size = sizeof taken;
  ::getsockname(impl_->listener, reinterpret_cast<sockaddr*>(&taken), &size);
  return ntohs(taken.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(taken).sin6_port
                                           : reinterpret_cast<const sockaddr_in&>(taken).sin_port);
}

/// Closes the connection that has waited for longest to send its request or to take its answer, of those that have
/// waited so long at least.
bool HttpServer::Impl::make_room(bool sending_only, std::chrono::milliseconds least) {
  auto worst = connections.end();
  const Clock::time_point latest = Clock::now() - least;
  for (auto it = connections.begin(); it != connections.end(); ++it) {
    const Connection::State s = (*it)->state();
    if (s != Connection::State::Sending && (sending_only || s != Connection::State::Reading)) continue;
    if ((*it)->since() <= latest && (worst == connections.end() || (*it)->since() < (*worst)->since())) worst = it;
  }
  if (worst == connections.end()) return false;
  connections.erase(worst);
  return true;
}

std::size_t HttpServer::Impl::waiting() {
  std::size_t bytes = 0;
  for (const auto& c : connections) bytes += c->waiting();
  const std::lock_guard lock(mutex);
  for (const Done& d : done) bytes += d.response.body.size();
  return bytes;
}

void HttpServer::Impl::accept_all() {
  for (;;) {
    const int socket = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket < 0) {
      // Out of files: one of ours is given up for it.
      if ((errno == EMFILE || errno == ENFILE) && make_room()) continue;
      return;
    }
    const int yes = 1;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    if (connections.size() >= kMostConnections && !make_room()) {
      ::close(socket);
      continue;
    }
    connections.push_back(std::make_unique<Connection>(socket, ++numbers));
  }
}

void HttpServer::Impl::serve(Connection& c, short what, std::vector<std::uint64_t>& over) {
  bool good = (what & (POLLERR | POLLNVAL)) == 0;
  if (good && what & (POLLIN | POLLHUP) && c.state() != Connection::State::Answering) good = c.receive();
  if (good && c.state() == Connection::State::Answering && what & POLLHUP) good = false;
  // A page may send several requests at once.
  if (good)
    if (auto request = c.take_request()) held.push_back({c.number(), std::move(*request)});
  if (good && c.waiting() > 0) good = c.send();
  if (!good || Clock::now() > c.deadline()) over.push_back(c.number());
}

void HttpServer::Impl::drop(const std::vector<std::uint64_t>& over) {
  std::erase_if(connections, [&](const auto& c) { return std::ranges::find(over, c->number()) != over.end(); });
}

void HttpServer::Impl::take_results(std::vector<std::uint64_t>& over) {
  std::vector<Done> results;
  std::string latest;
  bool say_here = false;
  {
    const std::lock_guard lock(mutex);
    results.swap(done);
    latest = news;
    say_here = std::exchange(comment, false);
  }
  for (const auto& c : connections) {
    if (c->state() != Connection::State::Streaming) continue;
    if ((!latest.empty() && latest != told && !c->tell(latest)) || (say_here && !c->tell(": still here\n\n")))
      over.push_back(c->number());
  }
  told = latest;
  for (Done& d : results)
    for (const auto& c : connections) {
      if (c->number() != d.connection || c->state() != Connection::State::Answering) continue;
      if (d.response.events && streams() >= kMostStreams)
        d.response = HttpResponse::error(503, "too many pages are open at once");
      c->answer(d.response);
      if (c->state() == Connection::State::Streaming) c->tell(told);
    }
  const std::lock_guard lock(mutex);
  listeners = streams();
  if (listeners > 0) return;
  // What nobody listened to is old when somebody does.
  news.clear(), told.clear();
}

/// Hands requests to those who make answers, while what they made has been taken.
void HttpServer::Impl::dispatch() {
  std::erase_if(held, [&](const Job& j) {
    return std::ranges::none_of(connections, [&](const auto& c) { return c->number() == j.connection; });
  });
  if (held.empty()) return;
  while (waiting() >= kMostWaiting)
    if (!make_room(true, kStuck)) return;
  const std::lock_guard lock(mutex);
  for (; !held.empty() && jobs.size() < kThreads; held.pop_front()) jobs.push_back(std::move(held.front()));
  work.notify_all();
}

void HttpServer::Impl::make_answers() {
  for (;;) {
    Job job;
    {
      std::unique_lock lock(mutex);
      work.wait(lock, [&] { return stopping || !jobs.empty(); });
      if (stopping) return;
      job = std::move(jobs.front());
      jobs.pop_front();
    }
    Done d{job.connection, answer(job.request)};
    {
      const std::lock_guard lock(mutex);
      done.push_back(std::move(d));
    }
    poke();
  }
}

void HttpServer::Impl::look_for_news() {
  std::unique_lock lock(mutex);
  while (!stopping) {
    if (listeners > 0) {
      lock.unlock();
      std::string now = event();
      lock.lock();
      if (now != news) {
        news = std::move(now);
        silence = {};
        poke();
      } else if ((silence += pulse) >= kQuiet) {
        silence = {};
        comment = true;
        poke();
      }
    }
    work.wait_for(lock, pulse, [&] { return stopping.load(); });
  }
}

void HttpServer::listen() {
  Impl& d = *impl_;
  std::vector<std::jthread> helpers;
  for (std::size_t i = 0; i < kThreads; ++i) helpers.emplace_back([&] { d.make_answers(); });
  helpers.emplace_back([&] { d.look_for_news(); });
  std::vector<pollfd> watched;
  std::vector<std::uint64_t> over;
  while (!d.stopping) {
    watched.assign({{d.listener, POLLIN, 0}, {d.wake[0], POLLIN, 0}});
    for (const auto& c : d.connections) watched.push_back({c->socket(), c->wanted(), 0});
    const int ready = ::poll(watched.data(), watched.size(), static_cast<int>(kPulse.count()));
    if (ready < 0 && errno != EINTR) break;
    over.clear();
    for (std::size_t i = 0; i < d.connections.size(); ++i)
      d.serve(*d.connections[i], ready < 0 ? short{0} : watched[i + 2].revents, over);
    d.drop(over);
    over.clear();
    if (char bytes[256]; watched[1].revents != 0)
      while (::read(d.wake[0], bytes, sizeof bytes) > 0) {
      }
    d.take_results(over);
    d.drop(over);
    d.dispatch();
    if (watched[0].revents != 0) d.accept_all();
  }
  stop();
  helpers.clear();
  d.connections.clear();
}

void HttpServer::stop() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->stopping = true;
  }
  impl_->work.notify_all();
  impl_->poke();
}

}  // namespace brim::viewer
