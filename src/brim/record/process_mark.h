#pragma once

#include <cstdint>
#include <string>

namespace brim {

/// A process, so that another can ask whether it still runs.
struct ProcessMark {
  std::int64_t pid = 0;  ///< 0: not known
  std::string host;
  std::string started;  ///< when, in the kernel's words; tells it from a later one of the same number
};

enum class ProcessState { Running, Gone, Unknown };

ProcessMark this_process();

/// Unknown for a process of another machine, and where none was recorded.
ProcessState state_of(const ProcessMark& mark);

}  // namespace brim
