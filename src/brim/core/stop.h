#pragma once

#include <functional>
#include <utility>

namespace brim {

/// Exception that unwinds work which was asked to end (StopScope).
struct Stopped {};

/// Lets long work on this thread be ended from outside: while the scope lives, check_stop() calls `asked`. The work is
/// left half done; whoever asked it to end must restore the state. Work that is not ended has the same bits as without
/// a scope. Scopes may be nested; the innermost one is asked.
/// Tests: tests/core/stop_test.cpp
class StopScope {
 public:
  using Asked = std::function<bool()>;

  /// @param asked  returns true to end the work; must outlive the scope; may be empty (never ends)
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

/// Called by long work between sub-steps, iterations and sweeps.
/// @throws Stopped  when a StopScope of this thread says so
inline void check_stop() {
  if (const StopScope::Asked* asked = StopScope::innermost(); asked != nullptr && (*asked)()) throw Stopped{};
}

}  // namespace brim
