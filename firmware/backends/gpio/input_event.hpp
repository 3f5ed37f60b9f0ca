#pragma once

#include <cstdint>

namespace roadbalance {

/// An event on an input of a GPIO chip.
struct InputEvent {
  enum Kind : std::uint8_t {
    kFalling,
    kRising,
    kLost,  ///< edges of this input may be missing before this instant
  };
  std::int64_t monotonic_ns = 0;                ///< CLOCK_MONOTONIC, as the kernel stamps edges
  std::int64_t machine_minus_monotonic_ns = 0;  ///< when it was read
  std::uint8_t input = 0;                       ///< which
  Kind kind = kRising;
};

}  // namespace roadbalance
