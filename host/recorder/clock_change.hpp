#pragma once

#include <cstdint>

namespace roadbalance {

/// The wall clock was set if it went so much further than the machine's from one turn to the next: slewing
/// takes longer.
inline constexpr std::int64_t kClockSet_us = 500'000;

}  // namespace roadbalance
