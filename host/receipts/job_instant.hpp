#pragma once

#include <cstdint>

#include "common/clock/clocks.hpp"
#include "common/clock/utc.hpp"

namespace roadbalance {

/// An instant as people tell it, and by the clock that nobody steps: what lasts is measured by the latter.
struct JobInstant {
  std::int64_t utc_us = 0;
  WallTime steady{};

  static JobInstant now() { return {roadbalance::utc_us(), WallClock::now()}; }
};

}  // namespace roadbalance
