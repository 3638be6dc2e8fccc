#include "brim/core/alone.h"

#include <oneapi/tbb/task_arena.h>

namespace brim {

void run_alone(const std::function<void()>& f) {
  tbb::task_arena arena(1);
  arena.execute(f);
}

}  // namespace brim
