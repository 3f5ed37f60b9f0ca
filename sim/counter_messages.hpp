#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/types/scan.hpp"

namespace roadbalance::sim {

/// A control unit's counter once so many teeth have passed: it moves by steps and wraps.
double counter_code(double teeth_passed, std::int64_t modulus, std::int64_t step = 1);

/// Messages of a control unit for a tone wheel that turns by any function of time: how many of its even teeth
/// have passed, sampled some time before the message is stamped.
struct CounterMessages {
  std::function<double(double)> angle_rad;  ///< of seconds
  int teeth = 96;
  double first_tooth_rad = 0.02;
  std::int64_t modulus = 1024;
  double rate_hz = 50.0;
  double latency_s = 0.010, jitter_s = 0.0;  ///< of the stamp behind the count: mean, rms of a normal one
  double lost = 0.0;                         ///< share of messages
  /// Teeth that the unit had not counted by then.
  std::function<double(double)> lost_counts = [](double) { return 0.0; };
  std::uint64_t seed = 1;
  std::uint16_t signal = 0;

  /// In order of stamp.
  std::vector<SignalSample> samples(double from_s, double to_s) const;
};

}  // namespace roadbalance::sim
