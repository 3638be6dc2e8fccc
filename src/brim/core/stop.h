#pragma once

#include <functional>
#include <utility>

namespace brim {

/// What unwinds work that was asked to end (StopScope).
struct Stopped {};

/// Lets what takes long on this thread be ended from outside: while it lives, check_stop() asks `asked`. The work is
/// left where it stands, so that whoever asks to end it takes back what it has changed. What is not asked to end has
/// the same bits as without. Scopes may be nested; the innermost one is asked.
/// Tests: tests/core/stop_test.cpp
class StopScope {
 public:
  using Asked = std::function<bool()>;

  /// @param asked  true ends the work; outlives the scope; empty: nobody ends it
  explicit StopScope(const Asked& asked) : before_(std::exchange(innermost(), asked ? &asked : nullptr)) {}
  ~StopScope() { innermost() = before_; }
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

 private:
  friend void check_stop();
  static const Asked*& innermost() {
    thread_local const Asked* asked = nullptr;
    return asked;
  }
  const Asked* before_;
};

/// Called now and then by what takes long: between sub-steps, iterations and sweeps.
/// @throws Stopped  when a StopScope of this thread says so
inline void check_stop() {
  if (const StopScope::Asked* asked = StopScope::innermost(); asked != nullptr && (*asked)()) throw Stopped{};
}

}  // namespace brim
