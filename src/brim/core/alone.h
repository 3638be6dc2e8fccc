#pragma once

#include <functional>

namespace brim {

/// Calls f on this thread alone: parallel loops inside it run serially and wait for no other thread. For a forked
/// process, in which the threads of the pool do not exist.
void run_alone(const std::function<void()>& f);

}  // namespace brim
