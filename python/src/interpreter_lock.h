#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <thread>

#if defined(__GLIBCXX__)
#include <cxxabi.h>
#endif

namespace brim::python {

// The interpreter's lock, for threads that may outlive the interpreter: those of Python that are daemons, and what runs
// for them. An interpreter that ends takes such a thread's life where it asks for the lock, by unwinding its stack,
// which no destructor and no C++ thread that waits for another survives: the process would be aborted. Here the thread
// stays where it is instead, until the process has ended. Tests: python/tests/exit_test.py

/// Waits for ever, without the lock.
[[noreturn]] void stay();

/// True once the interpreter ends, for all threads but the one that ends it.
bool interpreter_ends(std::thread::id thread = std::this_thread::get_id());

/// Lets the interpreter wait at its end for what runs without the lock: asked to stop, steps do so soon (StopScope).
/// What takes longer than ten seconds is not waited for.
void watch_for_end();

/// Runs f, which asks for the lock or holds it; where the interpreter ends this thread in it, the thread stays.
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

/// Leaves the lock, which must be held, to others while it lives.
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
