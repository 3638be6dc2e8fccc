#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace brim {

/// What a profile knows of one phase of one kind of body ("" where no kind is meant).
struct ProfileEntry {
  std::string phase, kind;
  double seconds = 0.0;  ///< [s] summed over threads, without that of scopes inside
  std::int64_t calls = 0;
  double bytes = 0.0;  ///< read and written, estimated from the sizes of arrays
};

/// A number that parts of the program add up, such as the entries of a factor.
struct ProfileCount {
  std::string name;
  std::int64_t times = 0;
  double sum = 0.0, largest = 0.0;
};

/// The count of what steps spend in loops that threads may share (loop_seconds).
inline constexpr std::string_view kSecondsInLoops = "seconds in loops";

/// Turns the profile of this process on (from zero) or off, which it is at the start. Results of a simulation never
/// depend on it.
void set_profile(bool on);

/// What was measured since, in order of phase and kind. Call it while nothing that is measured runs.
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

/// Adds the time of its scope on this thread to a phase; that of scopes inside it, on the same thread, is theirs. Where
/// the profile is off it costs a load and a branch.
///   const ProfileScope scope("product", body);
/// @param phase  a string literal
class ProfileScope {
 public:
  explicit ProfileScope(const char* phase) {
    if (profile_on()) open(phase, "");
  }
  /// @param body  anything with kind(), the word for its kind
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
