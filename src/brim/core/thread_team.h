#pragma once

#include <cstddef>
#include <memory>

namespace brim {

/// The threads that share the loops of parallel_for: one a core, started when a loop first asks for them. They wait for
/// the next loop awake, for about a millisecond, as the loops of a solve follow each other within microseconds, where
/// waking a thread takes tens of them.
///
///   caller   ──open──┬─ pieces of its own range, then of others' ─┬─ waits for the last ── close ──
///   others           └─ likewise, each from its own range on ─────┘
///
/// A loop is cut into equal pieces, dealt to threads as ranges: the same thread comes to the same part of an array loop
/// after loop, where its cache may still hold it. Who has finished takes from the ends of the ranges of others. A piece
/// may run a loop of its own; who waits for a loop to end helps with loops within it alone, not with what could take
/// longer. What a piece throws is thrown to the caller once all have run: that of the first piece which threw. A
/// process that was forked has one thread: its caller then runs all pieces by itself. Tests:
/// tests/core/thread_team_test.cpp
class ThreadTeam {
 public:
  /// Calls (work, begin, end) for ranges that make up [0, n).
  using Piece = void (*)(const void* work, std::size_t begin, std::size_t end);

  /// @param size  threads at most, the caller of a loop counted
  explicit ThreadTeam(int size);
  /// No loop may run any more.
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  /// The team of the process, of as many threads as it has cores(). It lives until the process ends.
  static ThreadTeam& shared();
  /// The caller's number in its team: 0 for threads that are of none.
  static int number();
  /// Threads of the machine that this process may use.
  static int cores();

  /// Runs a loop, and returns when all of it is done. @param grain  least length of a piece  @param threads  that may
  /// take part, the caller counted; at most the team's size do
  void run(std::size_t n, std::size_t grain, int threads, const void* work, Piece piece);

 private:
  struct Range;
  struct Loop;
  struct Worker;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace brim
