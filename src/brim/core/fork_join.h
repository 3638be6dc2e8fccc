#pragma once

// GCC says it by a macro, Clang by a feature. Eigen defines __has_feature where there is none, so the macro comes
// first.
#if defined(__SANITIZE_THREAD__)
#define BRIM_THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define BRIM_THREAD_SANITIZER 1
#endif
#endif

#ifdef BRIM_THREAD_SANITIZER
extern "C" void __tsan_acquire(void* address);
extern "C" void __tsan_release(void* address);
/// Marks a function that TBB copies between threads: the sanitizer does not see how its captures got there.
#define BRIM_UNSEEN __attribute__((no_sanitize("thread")))
#else
#define BRIM_UNSEEN
#endif

namespace brim::detail {

/// Tells the thread sanitizer what it cannot see inside the TBB library, which is not compiled with it: that all work
/// of a parallel loop starts after the call and ends before its return. Nothing orders two pieces of work, so races
/// between them are still found. Costs nothing in other builds.
///
///   caller   ──fork──┬── work ──┬──join──
///   worker           └── work ──┘
class ForkJoin {
 public:
#ifdef BRIM_THREAD_SANITIZER
  /// @param work  what the loop calls: the compiler must have stored it, and what it refers to, before the fork
  explicit ForkJoin(const void* work) {
    asm volatile("" : : "r"(work) : "memory");
    __tsan_release(&fork_);
  }
  ~ForkJoin() { __tsan_acquire(&join_); }
  /// Lives as long as one piece of work.
  class Work {
   public:
    explicit Work(ForkJoin& edges) : edges_(edges) { __tsan_acquire(&edges.fork_); }
    ~Work() { __tsan_release(&edges_.join_); }

   private:
    ForkJoin& edges_;
  };

 private:
  char fork_ = 0, join_ = 0;
#else
  explicit ForkJoin(const void*) {}
  ~ForkJoin() {}
  struct Work {
    explicit Work(ForkJoin&) {}
    ~Work() {}
  };
#endif
};

}  // namespace brim::detail
