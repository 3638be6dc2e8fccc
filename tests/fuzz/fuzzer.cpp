#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "fuzz/file_targets.h"

/// libFuzzer's entry: BRIM_FUZZ_TARGET names what is done with the bytes (./dev fuzz).
namespace {

const brim::fuzz::FileTarget& chosen() {
  const char* name = std::getenv("BRIM_FUZZ_TARGET");
  for (const brim::fuzz::FileTarget& t : brim::fuzz::kFileTargets)
    if (name != nullptr && std::strcmp(t.name, name) == 0) return t;
  std::fputs("BRIM_FUZZ_TARGET must be one of:\n", stderr);
  for (const brim::fuzz::FileTarget& t : brim::fuzz::kFileTargets) std::fprintf(stderr, "%s\n", t.name);
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const brim::fuzz::FileTarget& target = chosen();
  target.read({data, size});
  return 0;
}
