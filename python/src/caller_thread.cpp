#include "caller_thread.h"

#include "interpreter_lock.h"

namespace brim::python {

namespace py = pybind11;

void CallerThread::serve(Request& request) {
  request.failed = true;
  if (interpreter_ends()) return;
  const Locked lock;
  try {
    outlive(*request.f);
    request.failed = false;
  } catch (...) {
    if (!failure_) failure_ = std::current_exception();
  }
}

void CallerThread::run(const std::function<void()>& work) {
  std::exception_ptr thrown;
  failure_ = nullptr;
  {
    const Unlocked unlocked;
    {
      const std::lock_guard hold(mutex_);
      server_ = std::this_thread::get_id();
      ended_ = false;
    }
    std::thread worker([&] {
      try {
        work();
      } catch (...) {
        thrown = std::current_exception();
      }
      const std::lock_guard hold(mutex_);
      ended_ = true;
      asked_.notify_one();
    });
    std::unique_lock hold(mutex_);
    for (;;) {
      asked_.wait(hold, [&] { return ended_ || !waiting_.empty(); });
      if (waiting_.empty()) break;
      Request* request = waiting_.front();
      waiting_.pop_front();
      hold.unlock();
      serve(*request);
      hold.lock();
      request->done = true;
      answered_.notify_all();
    }
    hold.unlock();
    worker.join();
    const std::lock_guard again(mutex_);
    server_ = {};
  }
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  if (thrown) std::rethrow_exception(thrown);
}

void CallerThread::call(const std::function<void()>& f) {
  std::unique_lock hold(mutex_);
  if (server_ == std::thread::id{} || server_ == std::this_thread::get_id()) {
    hold.unlock();
    const Locked lock;
    f();
    return;
  }
  Request request{&f};
  waiting_.push_back(&request);
  asked_.notify_one();
  answered_.wait(hold, [&] { return request.done; });
  if (request.failed) throw CallFailed{};
}

}  // namespace brim::python
