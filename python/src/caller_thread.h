#pragma once

#include <pybind11/pybind11.h>

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace brim::python {

/// Lets code below a step call Python on the thread that requested the step, from any of brim's threads. The step runs
/// on a thread of its own, and the requesting thread serves its calls, one at a time, with the interpreter's lock; in
/// between other Python threads run.
class CallerThread {
 public:
  /// Runs `work`. The interpreter's lock must be held; it is released except during calls.
  /// @throws on this thread the exceptions of work, and those raised by Python in a call
  void run(const std::function<void()>& work);
  /// Runs f with the interpreter's lock on the thread in run(); directly if that is this thread, or there is none.
  /// @throws CallFailed  when f threw below run(); run() then throws the original exception
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
