#pragma once

#include <functional>

namespace brim {

/// Calls f on this thread alone: loops inside it start no others and wait for none. For a process that was forked, in
/// which the pool's other threads do not exist.
void run_alone(const std::function<void()>& f);

}  // namespace brim
