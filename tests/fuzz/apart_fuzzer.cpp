#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <utility>

#include "brim/io/child_reader.h"
#include "fuzz/file_targets.h"

/// libFuzzer's entry for readers that work in a process of their own, of libraries that damaged files may end: what
/// must hold is that the process that asked goes on, with the file or with one InputError, in time.
///
///   libFuzzer  --input-->  a process that reads one input after another       as long as it lives
///              --input-->  the reader as users have it, a fork for the file   for each input that ended that process
///              (of
///                                                                             those that took too long, one of kLate),
///                                                                             and for one of kEvery
///
/// A fork with these libraries takes 5 to 15 ms, hence the first way. There are no address checks, and the libraries
/// are not instrumented; instead each new outcome counts as covered: message or result, without its numbers.
namespace {

using brim::ChildReader;
using brim::fuzz::Outcome;

constexpr std::size_t kMostBytes = 1 << 20;
constexpr unsigned kEvery = 64, kLate = 64;
constexpr rlim_t kSpared = rlim_t{448} << 20;             // [bytes] of the 512 MiB that any file may take
constexpr std::string_view kWantsMemory = "more memory";  // in the outcome of an input that asked for too much
constexpr int kMilliseconds = 20;                         // of processor time, for an input in the first process

__attribute__((section("__libfuzzer_extra_counters"))) std::uint8_t outcomes[1 << 14];

/// FNV-1a (Fowler, Noll and Vo) of the text without digits.
std::uint32_t hash_of(std::string_view text) {
  std::uint32_t hash = 2166136261u;
  for (const char c : text)
    if (c < '0' || c > '9') hash = (hash ^ static_cast<std::uint8_t>(c)) * 16777619u;
  return hash;
}

/// The process that reads one input after another, handed over in shared memory.
class Worker {
 public:
  explicit Worker(const brim::fuzz::FileTarget& target)
      : target_(target),
        shared_(static_cast<std::uint8_t*>(
            ::mmap(nullptr, kMostBytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {
    if (shared_ == MAP_FAILED) throw std::runtime_error("no shared memory");
    // The tables that libraries make once are made here, not in each fork, by a file that does them no harm.
    std::ifstream whole("tests/fuzz/inputs/dicom/plain.dcm", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(whole), {}};
    ChildReader::answer_here(true);
    target.read({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    ChildReader::answer_here(false);
  }

  /// @throws brim::InputError  when the input ends the process; the next has a new one
  Outcome read(brim::fuzz::Bytes bytes) {
    if (!process_) start();
    std::copy(bytes.begin(), bytes.end(), shared_);
    try {
      const Outcome outcome = process_->ask(static_cast<int>(bytes.size())).get_text();
      // Libraries lose what they had when memory ran out: the inputs after it would all be refused for that.
      if (outcome.find(kWantsMemory) != Outcome::npos) process_.reset();
      return outcome;
    } catch (const brim::InputError&) {
      process_.reset();
      throw;
    }
  }

 private:
  void start() {
    brim::fuzz::folder();  // that of this process, for all
    ChildReader::set_base_seconds(600.0);
    process_ =
        std::make_unique<ChildReader>("input", [this, first = true](int size, ChildReader::Answer& answer) mutable {
          if (std::exchange(first, false)) begin();
          const itimerval limit{{0, 0}, {0, 1000 * kMilliseconds}}, none{};
          ::setitimer(ITIMER_PROF, &limit, nullptr);
          answer.put_text(target_.read({shared_, static_cast<std::size_t>(size)}));
          ::setitimer(ITIMER_PROF, &none, nullptr);
        });
    ChildReader::set_base_seconds(1.0);
  }

  /// In the process itself: no forks, and an eighth of the memory, as much of which is asked for in vain.
  static void begin() {
    ChildReader::answer_here(true);
    std::signal(SIGPROF, SIG_DFL);
    rlimit space{};
    ::getrlimit(RLIMIT_AS, &space);
    space.rlim_cur -= kSpared;
    ::setrlimit(RLIMIT_AS, &space);
  }

  const brim::fuzz::FileTarget& target_;
  std::uint8_t* shared_;
  std::unique_ptr<ChildReader> process_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const brim::fuzz::FileTarget& target = brim::fuzz::chosen_target(brim::fuzz::Where::Apart);
  static Worker worker(target);
  static unsigned count = 0, late = 0;
  if (size > kMostBytes) return 0;
  const auto begin = std::chrono::steady_clock::now();
  Outcome outcome;
  bool again = ++count % kEvery == 0;
  try {
    outcome = worker.read({data, size});
  } catch (const brim::InputError&) {
    outcome = "it ended";
    const bool quick = std::chrono::steady_clock::now() - begin < std::chrono::milliseconds(kMilliseconds);
    again = quick || ++late % kLate == 1;
  }
  if (again) outcome = target.read({data, size});
  outcomes[hash_of(outcome) % std::size(outcomes)] = 1;
  return 0;
}
