#pragma once

#include <cstdint>
#include <optional>

namespace roadbalance {

/// A pulse counter that a control unit of the car sends, as far as it is known beforehand.
struct CounterForm {
  std::int64_t modulus = 1024;                       ///< codes before it begins again at 0
  std::optional<std::int64_t> invalid_code = 0x3FF;  ///< means that there is no count
  std::int64_t step = 1;                             ///< it only ever moves by multiples of this
  double highest_rate_hz = 3000.0;                   ///< counts a second that are never exceeded
  double highest_change_hz_s = 1000.0;               ///< by which that rate changes a second at the most
  double jitter_s = 0.002;                           ///< a message's age differs from the next one's by less
};

/// How old a count is when its message is stamped: sampled by the control unit, then sent when its turn came.
struct CounterLatency {
  double mean_s = 0.0;        ///< stamp minus the instant at which the counter had the count
  double mean_sigma_s = 0.0;  ///< standard deviation of our knowledge of the mean
  double jitter_s = 0.0;      ///< standard deviation of one message about the mean
};

}  // namespace roadbalance
