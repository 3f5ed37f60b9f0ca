#pragma once

#include <cstdio>
#include <cstdlib>

namespace roadbalance::fuzz {

/// Ends the run, so that the fuzzer keeps the input, unless the property holds.
inline void require(bool holds, const char* property) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", property);
  std::abort();
}

}  // namespace roadbalance::fuzz
