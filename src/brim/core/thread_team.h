#pragma once

#include <cstddef>
#include <memory>

namespace brim {

/// The threads that share the loops of parallel_for: one per core, started at the first loop. They wait for the next
/// loop awake, for about a millisecond: the loops of a solve follow each other within microseconds, and waking a thread
/// takes tens of them.
///
///   caller   ──open──┬─ pieces of its own range, then of others' ─┬─ waits for the last ── close ──
///   others           └─ likewise, each from its own range on ─────┘
///
/// A loop is cut into equal pieces, dealt to threads as ranges: the same thread gets the same part of an array loop
/// after loop, where its cache may still hold it. A thread that has finished its range takes pieces from the ends of
/// other ranges. A piece may run a loop of its own; a thread that waits for a loop to end helps only with loops nested
/// in it, since others could take longer. An exception in a piece is thrown to the caller once all pieces have run; of
/// several, that of the first piece. In a forked process the caller runs all pieces by itself.
/// Tests: tests/core/thread_team_test.cpp
class ThreadTeam {
 public:
  /// Calls (work, begin, end) for ranges that make up [0, n).
  using Piece = void (*)(const void* work, std::size_t begin, std::size_t end);

  /// @param size  largest number of threads, the caller of a loop included
  explicit ThreadTeam(int size);
  /// No loop may be running.
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  /// The team of the process, with cores() threads. It lives until the process ends.
  static ThreadTeam& shared();
  /// The calling thread's number in its team: 0 for threads outside a team.
  static int number();
  /// Hardware threads that this process may use.
  static int cores();

  /// Runs a loop and returns when all of it is done.
  /// @param grain    minimum length of a piece
  /// @param threads  maximum number of threads, the caller included; at most the team's size are used
  void run(std::size_t n, std::size_t grain, int threads, const void* work, Piece piece);

 private:
  struct Range;
  struct Loop;
  struct Worker;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace brim
