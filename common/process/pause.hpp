#pragma once

#include <chrono>
#include <stop_token>

namespace roadbalance {

/// Waits for so long, or until asked to stop.
/// @return false: asked to stop
bool pause(const std::stop_token& stop, std::chrono::nanoseconds duration);

}  // namespace roadbalance
