#include "brim/record/process_mark.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <sstream>

namespace brim {

namespace {

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

/// Field 22 of /proc/<pid>/stat, in clock ticks since the machine started (proc(5)); empty where there is no such file.
std::string start_of(std::int64_t pid) {
  std::ifstream in(fmt::format("/proc/{}/stat", pid));
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t name_end = text.rfind(')');  // the second field may hold spaces
  if (name_end == std::string::npos) return {};
  std::istringstream rest(text.substr(name_end + 1));
  std::string field;
  for (int n = 3; n <= 22 && rest >> field; ++n)
    if (n == 3 && field == "Z") return "ended";  // dead, and not yet buried by its parent
  return field;
}

}  // namespace

ProcessMark this_process() { return {::getpid(), host_name(), start_of(::getpid())}; }

ProcessState state_of(const ProcessMark& mark) {
  if (mark.pid <= 0 || mark.host.empty() || mark.host != host_name()) return ProcessState::Unknown;
  if (::kill(static_cast<pid_t>(mark.pid), 0) != 0 && errno == ESRCH) return ProcessState::Gone;
  return start_of(mark.pid) == mark.started ? ProcessState::Running : ProcessState::Gone;
}

}  // namespace brim
