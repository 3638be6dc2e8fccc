#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace brim {

/// Profile of one phase and one kind of body ("" when the phase has no body).
struct ProfileEntry {
  std::string phase, kind;
  double seconds = 0.0;  ///< [s] summed over threads, nested scopes excluded
  std::int64_t calls = 0;
  double bytes = 0.0;  ///< read and written, estimated from the sizes of arrays
};

/// A number that parts of the program sum up, such as the entries of a factor.
struct ProfileCount {
  std::string name;
  std::int64_t times = 0;
  double sum = 0.0, largest = 0.0;
};

/// Name of the count for the time that steps spend in parallel loops (loop_seconds).
inline constexpr std::string_view kSecondsInLoops = "seconds in loops";

/// Turns the profile of this process on (from zero) or off; off at the start. It never changes the results of a
/// simulation.
void set_profile(bool on);

/// Measurements since then, sorted by phase and kind. Not to be called while measured code runs.
std::vector<ProfileEntry> profile_entries();
std::vector<ProfileCount> profile_counts();

namespace detail {
extern std::atomic<bool> profile_on;
struct ProfileSlot;
ProfileSlot* open_profile(const char* phase, std::string_view kind, ProfileSlot*& outer);
void close_profile(ProfileSlot* slot, ProfileSlot* outer, double seconds);
void add_profile_bytes(double bytes);
void add_profile_count(const char* name, double amount);
}  // namespace detail

inline bool profile_on() { return detail::profile_on.load(std::memory_order_relaxed); }

/// Adds the time of its scope on this thread to a phase, without the time of nested scopes on the same thread. With the
/// profile off it costs a load and a branch.
///   const ProfileScope scope("product", body);
/// @param phase  a string literal
class ProfileScope {
 public:
  explicit ProfileScope(const char* phase) {
    if (profile_on()) open(phase, "");
  }
  /// @param body  any object with kind(), the name of its kind
  template <class B>
  ProfileScope(const char* phase, const B& body) {
    if (profile_on()) open(phase, body.kind());
  }
  ~ProfileScope() {
    if (slot_ != nullptr)
      detail::close_profile(slot_, outer_, std::chrono::duration<double>(Clock::now() - start_).count());
  }
  ProfileScope(const ProfileScope&) = delete;
  ProfileScope& operator=(const ProfileScope&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  void open(const char* phase, std::string_view kind) {
    slot_ = detail::open_profile(phase, kind, outer_);
    start_ = Clock::now();
  }
  detail::ProfileSlot *slot_ = nullptr, *outer_ = nullptr;
  Clock::time_point start_;
};

/// Adds memory traffic to the innermost scope that is open on this thread. @param bytes  read and written
inline void profile_bytes(double bytes) {
  if (profile_on()) detail::add_profile_bytes(bytes);
}

/// Adds to a count of the profile. @param name  a string literal: "entries of the factor"
inline void profile_count(const char* name, double amount = 1.0) {
  if (profile_on()) detail::add_profile_count(name, amount);
}

}  // namespace brim
