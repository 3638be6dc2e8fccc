#include "brim/core/profile.h"

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace brim {

namespace detail {

std::atomic<bool> profile_on{false};

/// Written by one thread only.
struct ProfileSlot {
  const char* phase;
  std::string kind;
  double seconds = 0.0, bytes = 0.0;
  std::int64_t calls = 0;
};

namespace {

struct CountSlot {
  const char* name;
  std::int64_t times = 0;
  double sum = 0.0, largest = 0.0;
};

/// What one thread measured. Slots stay where they are, as open scopes point to them.
struct ThreadProfile {
  std::deque<ProfileSlot> slots;
  std::deque<CountSlot> counts;
  ProfileSlot* open = nullptr;
};

std::mutex mutex;
std::vector<std::shared_ptr<ThreadProfile>> threads;

ThreadProfile& this_thread() {
  thread_local const std::shared_ptr<ThreadProfile> mine = [] {
    auto made = std::make_shared<ThreadProfile>();
    const std::scoped_lock lock(mutex);
    threads.push_back(made);
    return made;
  }();
  return *mine;
}

}  // namespace

ProfileSlot* open_profile(const char* phase, std::string_view kind, ProfileSlot*& outer) {
  ThreadProfile& t = this_thread();
  outer = t.open;
  // Literals mostly have one address each; where they have two, the reader joins them. Kinds may be a body's own
  // strings.
  for (ProfileSlot& s : t.slots)
    if (s.phase == phase && s.kind == kind) return t.open = &s;
  t.slots.push_back({phase, std::string(kind)});
  return t.open = &t.slots.back();
}

void close_profile(ProfileSlot* slot, ProfileSlot* outer, double seconds) {
  slot->seconds += seconds;
  if (outer != nullptr) outer->seconds -= seconds;
  ++slot->calls;
  this_thread().open = outer;
}

void add_profile_bytes(double bytes) {
  if (ProfileSlot* open = this_thread().open) open->bytes += bytes;
}

void add_profile_count(const char* name, double amount) {
  ThreadProfile& t = this_thread();
  auto it = std::find_if(t.counts.begin(), t.counts.end(), [&](const CountSlot& c) { return c.name == name; });
  if (it == t.counts.end()) it = t.counts.insert(t.counts.end(), CountSlot{name});
  ++it->times;
  it->sum += amount;
  it->largest = std::max(it->largest, amount);
}

}  // namespace detail

void set_profile(bool on) {
  const std::scoped_lock lock(detail::mutex);
  if (on)
    for (const auto& t : detail::threads) {
      for (detail::ProfileSlot& s : t->slots) s = {s.phase, s.kind};
      for (detail::CountSlot& c : t->counts) c = {c.name};
    }
  detail::profile_on = on;
}

std::vector<ProfileEntry> profile_entries() {
  const std::scoped_lock lock(detail::mutex);
  std::map<std::pair<std::string, std::string>, ProfileEntry> joined;
  for (const auto& t : detail::threads)
    for (const detail::ProfileSlot& s : t->slots) {
      if (s.calls == 0) continue;
      ProfileEntry& e = joined[{s.phase, s.kind}];
      e.phase = s.phase, e.kind = s.kind;
      e.seconds += s.seconds, e.calls += s.calls, e.bytes += s.bytes;
    }
  std::vector<ProfileEntry> out;
  for (auto& [key, e] : joined) out.push_back(std::move(e));
  return out;
}

std::vector<ProfileCount> profile_counts() {
  const std::scoped_lock lock(detail::mutex);
  std::map<std::string, ProfileCount> joined;
  for (const auto& t : detail::threads)
    for (const detail::CountSlot& c : t->counts) {
      if (c.times == 0) continue;
      ProfileCount& e = joined[c.name];
      e.name = c.name;
      e.times += c.times, e.sum += c.sum, e.largest = std::max(e.largest, c.largest);
    }
  std::vector<ProfileCount> out;
  for (auto& [key, e] : joined) out.push_back(std::move(e));
  return out;
}

}  // namespace brim
