#include "hil_tests/fuzz/edge_counters.hpp"

// By the linker, around what clang has put there.  In code that has such counters itself clang uses these
// names.
extern "C" std::uint8_t __start___sancov_cntrs[], __stop___sancov_cntrs[];

namespace roadbalance::fuzz {

std::span<std::uint8_t> edge_counters() {
  return {__start___sancov_cntrs, __stop___sancov_cntrs};
}

}  // namespace roadbalance::fuzz
