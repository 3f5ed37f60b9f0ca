#pragma once

#include <chrono>
#include <stop_token>

namespace roadbalance {

/// Waits for so long, or until told to stop.
/// @return false: told to stop
bool pause(const std::stop_token& stop, std::chrono::nanoseconds duration);

}  // namespace roadbalance
