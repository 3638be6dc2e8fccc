#include "fuzz/file_targets.h"

/// libFuzzer's entry for brim's own readers: BRIM_FUZZ_TARGET names what is done with the bytes (./dev fuzz).
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const brim::fuzz::FileTarget& target = brim::fuzz::chosen_target(brim::fuzz::Where::Here);
  target.read({data, size});
  return 0;
}
