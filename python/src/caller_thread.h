#pragma once

#include <pybind11/pybind11.h>

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace brim::python {

/// Lets code that runs below a step call Python on the thread that asked for the step, whichever thread of brim's loops
/// it runs on itself. The step runs on a thread of its own meanwhile, and the asking thread serves its calls, one at a
/// time, with the interpreter's lock; between them other threads of Python go on.
class CallerThread {
 public:
  /// Runs `work`. The interpreter's lock must be held; it is released but for calls.
  /// @throws whatever work throws, and what Python raised in a call, on this thread
  void run(const std::function<void()>& work);
  /// Runs f with the interpreter's lock on the thread in run(); at once where that is this thread, or there is none.
  /// @throws CallFailed  when f threw below run(); run() then throws what it was
  void call(const std::function<void()>& f);

  /// Unwinds a step whose call failed.
  struct CallFailed {};

 private:
  struct Request {
    const std::function<void()>* f;
    bool done = false, failed = false;
  };
  void serve(Request& request);

  std::mutex mutex_;
  std::condition_variable asked_, answered_;
  std::deque<Request*> waiting_;
  std::thread::id server_{};
  bool ended_ = false;
  std::exception_ptr failure_;  // of the first call that failed
};

}  // namespace brim::python
