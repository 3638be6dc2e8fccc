#include <csignal>

#include "commands.h"

namespace brim::cli {

namespace {

volatile std::sig_atomic_t came = 0;

void take(int signal) {
  came = 1;
  // A second one is in earnest.
  std::signal(signal, SIG_DFL);
}

}  // namespace

void watch_interrupts() {
  std::signal(SIGINT, take);
  std::signal(SIGTERM, take);
}

bool interrupted() { return came != 0; }

}  // namespace brim::cli
