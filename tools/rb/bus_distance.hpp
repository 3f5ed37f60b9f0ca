#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/angle/counter_unwrap.hpp"
#include "common/dbc/candump.hpp"
#include "common/dbc/dbc.hpp"

namespace roadbalance {

/// How far the car went by a speed on the bus: the integral of straight lines between its messages.
struct SpeedDistance {
  std::string signal;  ///< "MESSAGE.SIGNAL"
  std::int64_t messages = 0, refused = 0;
  /// Without a message for longer than kLongestSilence_s; not integrated over.
  std::int64_t silences = 0;
  double seconds = 0.0, metres = 0.0;
};
inline constexpr double kLongestSilence_s = 0.5;

/// The same of a counter of pulses or of distance.
struct CounterDistance {
  std::string signal;
  CounterUnwrap::Counters counters;
  std::int64_t messages = 0, runs = 0, counts = 0, step = 1;
  double metres_per_count = 0.0, seconds = 0.0, metres = 0.0;  ///< of all runs
};

struct BusDistance {
  CounterDistance counter;
  std::vector<SpeedDistance> speed;  ///< in the order of the DBC file
  std::int64_t frames = 0;
};

/// Both distances of a log of a car's bus.
///
/// The counter's unit is the metre, or a count is `metres_per_count`.  The speeds at
/// two messages of the counter, of its own message if that has one, else of any, bound how often it can have
/// wrapped between them.
///
/// @param counter  "MESSAGE.SIGNAL"
/// @throws ConfigError naming the signal at fault
BusDistance bus_distance(const std::vector<LoggedFrame>& log, const Dbc& dbc, const std::string& counter,
                         std::optional<double> metres_per_count);

/// For programs.
nlohmann::ordered_json distance_json(const BusDistance& distance);

/// For people: the counter, each speed with its difference, and why there is no angle.
std::vector<std::string> distance_lines(const BusDistance& distance);

}  // namespace roadbalance
