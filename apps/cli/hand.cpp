#include "hand.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "brim/core/error.h"
#include "brim/io/regular_file.h"
#include "brim/record/run_folder.h"
#include "commands.h"

namespace brim::cli {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

namespace {

Vec3 vector_of(const Json& x) { return {x.at(0).get<double>(), x.at(1).get<double>(), x.at(2).get<double>()}; }
Json list_of(const Vec3& x) { return Json::array({x.x(), x.y(), x.z()}); }

/// Where a vertex that a body shows is now.
Vec3 vertex_of(const Body& body, std::int64_t vertex) {
  const std::size_t n = body.display().vertices;
  if (vertex < 0 || vertex >= static_cast<std::int64_t>(n))
    throw InputError(fmt::format("grab: '{}' ({}) has no point {} to hold", body.name(), body.kind(), vertex));
  std::vector<Vec3f> shown(n);
  body.display_positions(shown);
  return shown[static_cast<std::size_t>(vertex)].cast<double>();
}

}  // namespace

Hand::Hand() {
  // Each message is whole, or not there.
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends_) != 0)
    throw InputError(fmt::format("the viewer cannot reach the run: {}", std::strerror(errno)));
}

Hand::~Hand() {
  for (const int end : ends_)
    if (end >= 0) ::close(end);
}

void Hand::write_to(const std::string& folder, bool go_on) {
  file_ = (std::filesystem::path(folder) / "pulls.json").string();
  if (!go_on) return;
  const auto text = read_regular_file(file_);
  if (!text) return;
  try {
    for (const Json& entry : Json::parse(*text).at("timeline")) entries_.push_back(entry.dump());
  } catch (const Json::exception&) {
    throw InputError(fmt::format("{}: is not what an interactive run wrote; move it away to go on", file_));
  }
}

void Hand::before_step(World& world) {
  const auto dt = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(world.options().time_step));
  const Clock::time_point now = Clock::now();
  // A run that is slower than the clock does not catch up in leaps.
  due_ = std::max(due_ + dt, now);
  for (;;) {
    std::array<char, 512> bytes;
    const ssize_t n = ::recv(ends_[0], bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (n > 0) {
      take(world, {bytes.data(), static_cast<std::size_t>(n)});
      continue;
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(due_ - Clock::now()).count();
    if (left <= 0 || interrupted()) return;
    pollfd waiting{ends_[0], POLLIN, 0};
    if (::poll(&waiting, 1, static_cast<int>(left)) < 0 || (waiting.revents & POLLHUP) != 0) return;
  }
}

void Hand::take(World& world, const std::string& asked) {
  const double time = world.state().time;
  try {
    const Json given = Json::parse(asked);
    Json entry = {{"at", time}};
    if (given.contains("grab")) {
      const int b = given.at("grab").get<int>();
      if (b < 0 || b >= world.body_count()) throw InputError(fmt::format("grab: body {} is not there", b));
      const Body& body = world.body(b);
      const Vec3 at = vertex_of(body, given.at("vertex").get<std::int64_t>()) + vector_of(given.at("offset"));
      world.grab(b, at);
      entry["grab"] = body.name(), entry["point"] = list_of(at);
    } else if (given.contains("pull")) {
      if (world.grabbed() < 0) return;  // what could not be grabbed is not pulled
      world.pull(vector_of(given.at("pull")));
      entry["pull"] = given.at("pull");
    } else {
      if (world.grabbed() < 0) return;
      world.release();
      entry["release"] = true;
    }
    entries_.push_back(entry.dump());
    written_ = false;
  } catch (const InputError& e) {
    // As what the timeline asks in vain: a warning of the step.
    world.schedule(time, [why = std::string(e.what())](World&) { throw InputError(why); });
  } catch (const Json::exception&) {
    // Not from the page's own server: nobody to tell.
  }
  if (world.grabbed() < 0) finish();
}

void Hand::finish() {
  if (written_ || file_.empty()) return;
  std::string text = "{\n  \"brim\": 1,\n  \"name\": \"pulls\",\n  \"bodies\": [],\n  \"timeline\": [";
  for (std::size_t i = 0; i < entries_.size(); ++i) text += (i > 0 ? ",\n    " : "\n    ") + entries_[i];
  write_whole(file_, text + "\n  ]\n}\n");
  written_ = true;
}

}  // namespace brim::cli
