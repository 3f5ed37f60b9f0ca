#pragma once

#include <optional>
#include <string>

#include "common/config/node_wiring.hpp"

namespace roadbalance {

/// Number (SignalSample::signal) of the first of a node's signals that is the wanted one; nothing: none is.
template <typename Wanted>
std::optional<int> first_signal(const NodeWiring& wiring, Wanted wanted) {
  for (int number = 0; const SignalConfig* const signal = wiring.signal(number); ++number)
    if (wanted(*signal)) return number;
  return std::nullopt;
}

/// The one that carries the steering angle.
inline std::optional<int> steering_signal(const NodeWiring& wiring) {
  return first_signal(
      wiring, [](const SignalConfig& signal) { return signal.quantity == SignalQuantity::kSteeringAngle; });
}

/// The pulse counter of that name (EncoderConfig::counter).
inline std::optional<int> counter_signal(const NodeWiring& wiring, const std::string& name) {
  if (name.empty()) return std::nullopt;
  return first_signal(wiring, [&](const SignalConfig& signal) {
    return signal.quantity == SignalQuantity::kPulseCounter && signal.name == name;
  });
}

/// The one that carries the speed of that wheel.
inline std::optional<int> speed_signal(const NodeWiring& wiring, const std::string& wheel) {
  return first_signal(wiring, [&](const SignalConfig& signal) {
    return signal.quantity == SignalQuantity::kWheelSpeed && signal.wheel == wheel;
  });
}

}  // namespace roadbalance
