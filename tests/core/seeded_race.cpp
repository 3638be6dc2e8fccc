// A wrong program: two pieces of a parallel loop write one number. Built with the thread sanitizer only, where it must
// fail; otherwise the suppressions in tools/tsan.supp would hide real races as well.
#include <chrono>
#include <cstdio>
#include <thread>

#include "brim/core/parallel.h"

int main() {
  int shared = 0;
  brim::parallel_for(64, [&](std::size_t) {
    // Long enough for a second thread to join in.
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    ++shared;
  });
  std::printf("%d\n", shared);
}
