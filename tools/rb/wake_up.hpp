#pragma once

#include <chrono>

#include "common/gpio/edge_limit.hpp"

namespace roadbalance {

struct WakeUpMeasurement {
  WakeUps worst;
  std::chrono::milliseconds duration{};
  bool realtime = false;  ///< the threads had real-time priority
};

/// How late threads of the priorities that matter to edges wake up here: each sleeps a millisecond at a time.
/// It says nothing of what the machine does at other times; so load it as it will be, and
/// measure long: the worst is rare.
/// @throws std::system_error if there is no thread to be had
WakeUpMeasurement measure_wake_ups(std::chrono::milliseconds duration);

}  // namespace roadbalance
