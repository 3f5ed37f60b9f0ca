#pragma once

#include <limits>
#include <string>
#include <vector>

#include "sim/pulse_train.hpp"

namespace roadbalance {

/// A pulse train whose angle is known, and how far an estimate may be from it.
struct EncoderRow {
  std::string name;
  sim::PulseTrain train;
  double seconds;  ///< of driving
  double from_s;   ///< the live angle is judged from here on: before, it learns
  double allowed_rms_deg;
  double allowed_max_deg = std::numeric_limits<double>::infinity();
};

/// The trains an encoder is accepted with: 40 s at 18 turns a second unless the name gives another speed,
/// judged after 20 s; the speed ramp takes 90 s and is judged after 60.  Speeds wander by 1 % at 0.21 and
/// 0.83 Hz.
std::vector<EncoderRow> encoder_rows();

}  // namespace roadbalance
