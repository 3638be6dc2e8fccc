#pragma once

#include <cstdint>
#include <string>

namespace brim {

/// Identifies a process, so that another can check whether it still runs.
struct ProcessMark {
  std::int64_t pid = 0;  ///< 0: unknown
  std::string host;
  std::string started;  ///< start time as given by the kernel; distinguishes it from a later process with the same pid
};

enum class ProcessState { Running, Gone, Unknown };

ProcessMark this_process();

/// Unknown for a process of another machine, and when none was recorded.
ProcessState state_of(const ProcessMark& mark);

}  // namespace brim
