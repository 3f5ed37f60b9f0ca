#include "sim/signals.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roadbalance::sim {
namespace {

constexpr double kCounterEnd = 256.0;

}  // namespace

Signals::Signals(const VehicleConfig& vehicle, const NodeConfig& node, const DrawnCar& car) {
  for (const CanConfig& can : node.wiring.can) {
    for (std::size_t k = 0; k < can.signal.size(); ++k) {
      const SignalConfig& wanted = can.signal[k];
      if (wanted.quantity == SignalQuantity::kOther) continue;
      Source source{static_cast<std::uint16_t>(static_cast<std::size_t>(can.first_signal) + k),
                    wanted.quantity,
                    1.0,
                    1.0,
                    0.0,
                    0.0};
      if (const WheelConfig* const wheel = vehicle.wheel_named(wanted.wheel)) {
        const auto w = static_cast<std::size_t>(vehicle.place_of(*wheel));
        source.told_radius_m = wheel->rolling_radius_m;
        source.true_radius_m = car.rolling_radius_m[w];
        source.pulses = wheel->encoder.pulses_per_turn;
        source.angle_rad = car.initial_angle_rad[w] - wheel->encoder.datum_rad;
      }
      source_.push_back(source);
    }
  }
}

SignalSample Signals::at(std::size_t k, NodeTime time, const Motion& motion) const {
  const Source& source = source_[k];
  const auto value = [&] {
    switch (source.quantity) {
      case SignalQuantity::kVehicleSpeed:
        return motion.speed_m_s;
      case SignalQuantity::kWheelSpeed:
        return motion.speed_m_s / source.true_radius_m * source.told_radius_m;
      case SignalQuantity::kPulseCounter: {
        const double turns =
            (motion.position_m / source.true_radius_m + source.angle_rad) / (2.0 * std::numbers::pi);
        const double passed = std::floor(turns * source.pulses);
        return passed - kCounterEnd * std::floor(passed / kCounterEnd);
      }
      case SignalQuantity::kSteeringAngle:
      case SignalQuantity::kOther:
        break;
    }
    return 0.0;
  };
  return {.time = time, .signal = source.signal, .value = value()};
}

}  // namespace roadbalance::sim
