#include "brim/io/child_reader.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>

#include "brim/core/alone.h"
#include "brim/core/error.h"

namespace brim {

namespace {

enum class Kind : std::uint64_t { Good, Refused, Failed };

struct Head {
  Kind kind;
  std::uint64_t size;
};

// The sanitizers take terabytes of address space for themselves.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kChecked = true;
#elif defined(__has_feature)
constexpr bool kChecked = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
constexpr bool kChecked = false;
#endif

constexpr double kMiB = 1048576.0;
constexpr double kBaseBytes = 512 * kMiB, kBytesPerByte = 64.0;
constexpr double kSecondsPerMiB = 2.0;
double base_seconds = 60.0;
bool answers_here = false;

bool send_all(int to, const void* data, std::size_t size) {
  const auto* from = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = ::send(to, from, size, MSG_NOSIGNAL);  // whom nobody listens to is told so
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    from += n, size -= static_cast<std::size_t>(n);
  }
  return true;
}

bool receive_all(int file, void* data, std::size_t size) {
  auto* to = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t n = ::read(file, to, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    to += n, size -= static_cast<std::size_t>(n);
  }
  return true;
}

/// [bytes] of address space of this process.
double address_space() {
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr) return 0.0;
  unsigned long pages = 0;
  const bool good = std::fscanf(file, "%lu", &pages) == 1;
  std::fclose(file);
  return good ? static_cast<double>(pages) * static_cast<double>(::sysconf(_SC_PAGESIZE)) : 0.0;
}

void limit(int what, double most) {
  rlimit now{};
  if (::getrlimit(static_cast<__rlimit_resource_t>(what), &now) != 0) return;
  const auto wanted = static_cast<rlim_t>(most);
  if (now.rlim_max != RLIM_INFINITY && now.rlim_max <= wanted) return;
  now.rlim_cur = now.rlim_max = wanted;
  ::setrlimit(static_cast<__rlimit_resource_t>(what), &now);
}

/// The same of what may be raised again, up to that.
void limit_for_now(int what, double most) {
  rlimit now{};
  if (::getrlimit(static_cast<__rlimit_resource_t>(what), &now) != 0) return;
  now.rlim_cur = std::min(now.rlim_max, static_cast<rlim_t>(most));
  ::setrlimit(static_cast<__rlimit_resource_t>(what), &now);
}

/// What is sent for one question.
struct Reply {
  Kind kind = Kind::Good;
  std::vector<char> bytes;  ///< the answer, or the reason why there is none
};

Reply reply_to(int question, const ChildReader::Serve& serve) {
  ChildReader::Answer answer;
  const auto failed = [](Kind kind, std::string_view why) { return Reply{kind, {why.begin(), why.end()}}; };
  try {
    run_alone([&] { serve(question, answer); });
  } catch (const InputError& error) {
    return failed(Kind::Refused, error.what());
  } catch (const std::bad_alloc&) {
    return failed(Kind::Failed, "it asks for more memory than a file of its size may need");
  } catch (const std::exception& error) {
    return failed(Kind::Failed, error.what());
  } catch (...) {
    return failed(Kind::Failed, "reading it failed");
  }
  return {Kind::Good, answer.take()};
}

/// What the child is and does until nothing more is asked; never returns.
[[noreturn]] void be_child(int channel, double bytes, double opening, double seconds, const ChildReader::Serve& serve) {
  // The parent's handlers are not for here; what libraries print when they give up is nobody's.
  for (const int s : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGPIPE}) std::signal(s, SIG_DFL);
  // A terminal interrupts its whole foreground group. The parent decides what that means, and ends this process with
  // its own: a reader that went first would look like a damaged file.
  for (const int s : {SIGINT, SIGTERM}) std::signal(s, SIG_IGN);
  if (const int nowhere = ::open("/dev/null", O_RDWR); nowhere >= 0)
    for (const int standard : {0, 1, 2}) ::dup2(nowhere, standard);
  limit(RLIMIT_CORE, 0.0);
  limit(RLIMIT_CPU, seconds);
  limit_for_now(RLIMIT_CPU, opening);
  if (!kChecked) limit(RLIMIT_AS, bytes);
  int question = 0;
  while (receive_all(channel, &question, sizeof question)) {
    const Reply reply = reply_to(question, serve);
    const Head head{reply.kind, reply.bytes.size()};
    if (!send_all(channel, &head, sizeof head) || !send_all(channel, reply.bytes.data(), reply.bytes.size())) break;
    limit_for_now(RLIMIT_CPU, seconds);
  }
  ::_exit(0);
}

}  // namespace

void ChildReader::set_base_seconds(double seconds) { base_seconds = seconds; }
void ChildReader::answer_here(bool here) { answers_here = here; }

namespace {

[[noreturn]] void refuse_answer(const std::string& path) {
  throw InputError(fmt::format("{}: the file is damaged: the process that reads it answers nonsense", path));
}

}  // namespace

void ChildReader::Received::get(void* to, std::size_t size) {
  if (size > left()) refuse_answer(path_);
  if (size == 0) return;  // also to nowhere
  std::memcpy(to, bytes_.data() + at_, size);
  at_ += size;
}

std::size_t ChildReader::Received::count_of(std::size_t size) {
  const auto count = get<std::size_t>();
  if (count > left() / size) refuse_answer(path_);
  return count;
}

std::string ChildReader::Received::get_text() {
  std::string text(count_of(1), '\0');
  get(text.data(), text.size());
  return text;
}

ChildReader::Load ChildReader::load_of(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  const double length = error ? 0.0 : static_cast<double>(size);
  return {length, length};
}

ChildReader::ChildReader(const std::string& path, Serve serve) : ChildReader(path, load_of(path), std::move(serve)) {}

ChildReader::ChildReader(const std::string& path, const Load& load, Serve serve) : path_(path) {
  bytes_ = kBaseBytes + kBytesPerByte * load.largest;
  const double by_size = kSecondsPerMiB * load.all / kMiB;
  seconds_ = base_seconds + by_size;
  opening_ = load.opening > 0.0 ? std::min(seconds_, load.opening + by_size) : seconds_;
  if (answers_here) {
    here_ = std::move(serve);
    return;
  }
  const double space = bytes_ + address_space();
  int ends[2] = {-1, -1};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw InputError(fmt::format("{}: no channel can be had to read it: {}", path, std::strerror(errno)));
  child_ = ::fork();
  if (child_ == 0) {
    ::close(ends[0]);
    be_child(ends[1], space, opening_, seconds_, serve);
  }
  const int why = errno;
  ::close(ends[1]);
  channel_ = ends[0];
  if (child_ < 0) {
    end();
    throw InputError(fmt::format("{}: no process can be had to read it: {}", path, std::strerror(why)));
  }
}

ChildReader::~ChildReader() { end(); }

void ChildReader::end() {
  if (channel_ >= 0) ::close(channel_);
  channel_ = -1;
  if (child_ <= 0) return;
  ::kill(child_, SIGKILL);
  while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
  child_ = -1;
}

bool ChildReader::receive(void* to, std::size_t size) {
  auto* at = static_cast<char*>(to);
  while (size > 0) {
    pollfd wait{channel_, POLLIN, 0};
    const int ready = ::poll(&wait, 1, static_cast<int>(2000.0 * seconds_));
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0)
      throw InputError(
          fmt::format("{}: nothing was read of it in {:.0f} s; the file is damaged", path_, 2.0 * seconds_));
    const ssize_t n = ready < 0 ? -1 : ::read(channel_, at, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += n, size -= static_cast<std::size_t>(n);
  }
  return true;
}

void ChildReader::fail() {
  int status = 0;
  pid_t ended = -1;
  do ended = ::waitpid(child_, &status, 0);
  while (ended < 0 && errno == EINTR);
  if (ended == child_) child_ = -1;
  const bool time = ended > 0 && WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
  end();
  if (time)
    throw InputError(fmt::format("{}: was not read in {:.0f} s of processor time; the file is damaged", path_,
                                 answered_ ? seconds_ : opening_));
  throw InputError(fmt::format("{}: the file is damaged: reading it ends the library that reads it", path_));
}

ChildReader::Received ChildReader::ask(int question) {
  Reply reply;
  if (here_) {
    reply = reply_to(question, here_);
  } else {
    if (channel_ < 0) throw InputError(path_ + ": cannot be read any further");
    Head head{};
    if (!send_all(channel_, &question, sizeof question) || !receive(&head, sizeof head)) fail();
    if (static_cast<double>(head.size) > bytes_) {  // more than it may have
      end();
      refuse_answer(path_);
    }
    reply = {head.kind, std::vector<char>(head.size)};
    if (!receive(reply.bytes.data(), reply.bytes.size())) fail();
  }
  answered_ = true;
  if (reply.kind == Kind::Good) return {path_, std::move(reply.bytes)};
  const std::string why(reply.bytes.begin(), reply.bytes.end());
  throw InputError(reply.kind == Kind::Refused ? why : fmt::format("{}: the file is damaged: {}", path_, why));
}

}  // namespace brim
