#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <thread>

#if defined(__GLIBCXX__)
#include <cxxabi.h>
#endif

namespace brim::python {

// The interpreter's lock, for threads that may outlive the interpreter: Python's daemon threads, and work done for
// them. An interpreter at its end kills such a thread when it requests the lock, by unwinding its stack; destructors
// and waiting C++ threads do not survive that, and the process would abort. Here the thread blocks instead until the
// process has ended. Tests: python/tests/exit_test.py

/// Blocks forever, without the lock.
[[noreturn]] void stay();

/// True once the interpreter is ending, for all threads except the one that ends it.
bool interpreter_ends(std::thread::id thread = std::this_thread::get_id());

/// Makes the interpreter wait at its end for work without the lock: steps asked to stop end soon (StopScope). Waits at
/// most ten seconds.
void watch_for_end();

/// Runs f, which requests or holds the lock; if the interpreter's end kills this thread in it, the thread blocks
/// instead.
template <class F>
void outlive(const F& f) {
#if defined(__GLIBCXX__)
  try {
    f();
  } catch (const abi::__forced_unwind&) {
    stay();
  }
#else
  f();
#endif
}

/// Holds the lock while it lives.
class Locked {
 public:
  Locked() {
    outlive([&] { lock_.emplace(); });
  }

 private:
  std::optional<pybind11::gil_scoped_acquire> lock_;
};

/// Releases the lock, which must be held, while it lives.
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* state_;
};

}  // namespace brim::python
