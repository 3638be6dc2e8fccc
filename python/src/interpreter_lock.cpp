#include "interpreter_lock.h"

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace brim::python {

namespace {

constexpr std::chrono::seconds kPatience{10};

struct Shared {
  std::mutex mutex;
  std::condition_variable changed;
  int without_lock = 0;  ///< who runs without the lock
  bool ends = false;
  std::thread::id ender;
};

/// Never destroyed: threads that stay may still look at it.
Shared& shared() {
  static Shared& s = *new Shared;
  return s;
}

void end() {
  Shared& s = shared();
  PyThreadState* const state = PyEval_SaveThread();
  {
    std::unique_lock hold(s.mutex);
    s.ends = true;
    s.ender = std::this_thread::get_id();
    s.changed.wait_for(hold, kPatience, [&] { return s.without_lock == 0; });
  }
  PyEval_RestoreThread(state);
}

}  // namespace

void stay() {
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

bool interpreter_ends(std::thread::id thread) {
  Shared& s = shared();
  const std::lock_guard hold(s.mutex);
  return s.ends && thread != s.ender;
}

void watch_for_end() { pybind11::module_::import("atexit").attr("register")(pybind11::cpp_function(&end)); }

Unlocked::Unlocked() : state_(PyEval_SaveThread()) {
  if (interpreter_ends()) stay();
  const std::lock_guard hold(shared().mutex);
  ++shared().without_lock;
}

Unlocked::~Unlocked() {
  {
    const std::lock_guard hold(shared().mutex);
    --shared().without_lock;
    shared().changed.notify_all();
  }
  if (interpreter_ends()) stay();
  outlive([&] { PyEval_RestoreThread(state_); });
}

}  // namespace brim::python
