#pragma once

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// A tachometer of one pulse a turn: each pulse is the zero mark, too, and marks beside it count nothing.
inline bool is_own_mark(const EncoderConfig& encoder) {
  return encoder.pulses_per_turn == 1 && encoder.zero_mark && encoder.counter.empty();
}

}  // namespace roadbalance
