// libFuzzer's door: BALLBAR_FUZZ_TARGET names the input. See scripts/fuzz.

#include <cstdio>
#include <cstdlib>

#include "fuzz/targets.hpp"

namespace {

const ballbar::fuzz::Target* chosen() {
  const char* name = std::getenv("BALLBAR_FUZZ_TARGET");
  for (const auto& target : ballbar::fuzz::kTargets)
    if (name && target.name == name) return &target;
  std::fprintf(stderr, "BALLBAR_FUZZ_TARGET must name a target of tests/fuzz/targets.hpp\n");
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const ballbar::fuzz::Target* const target = chosen();
  target->run({data, size});
  return 0;
}
