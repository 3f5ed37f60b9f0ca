#include "sim/signals.hpp"

#include <cmath>
#include <numbers>

#include "sim/counter_messages.hpp"

namespace roadbalance::sim {

Signals::Signals(const VehicleConfig& vehicle, const NodeConfig& node, const DrawnCar& car,
                 std::uint64_t seed) {
  for (const CanConfig& can : node.wiring.can) {
    for (std::size_t k = 0; k < can.signal.size(); ++k) {
      const SignalConfig& wanted = can.signal[k];
      if (wanted.quantity == SignalQuantity::kOther) continue;
      const auto number = static_cast<std::uint16_t>(static_cast<std::size_t>(can.first_signal) + k);
      Source source{.signal = number,
                    .quantity = wanted.quantity,
                    .nominal_radius_m = 1.0,
                    .true_radius_m = 1.0,
                    .pulses = 0.0,
                    .angle_rad = 0.0,
                    .counter = wanted.counter,
                    .latency = wanted.latency,
                    .age = RandomSequence(seed, Use::kCounterAge,
                                          static_cast<std::uint64_t>(node.id) * kMostSignals + number)};
      if (const WheelConfig* const wheel = vehicle.wheel_named(wanted.wheel)) {
        const auto w = static_cast<std::size_t>(vehicle.place_of(*wheel));
        source.nominal_radius_m = wheel->rolling_radius_m;
        source.true_radius_m = car.rolling_radius_m[w];
        source.pulses = wheel->encoder.pulses_per_turn;
        source.angle_rad = car.initial_angle_rad[w] - wheel->encoder.datum_rad;
      }
      source_.push_back(source);
    }
  }
}

double Signals::teeth_passed(const Source& source, std::int64_t instant, const Drive& drive) const {
  const double age_s = source.latency.mean_s + source.latency.jitter_s * source.age.normal(instant);
  const Motion then = drive.at(1e-9 * static_cast<double>(instant * kPeriod_ns) - age_s);
  const double turns = (then.position_m / source.true_radius_m + source.angle_rad) / (2.0 * std::numbers::pi);
  return turns * source.pulses;
}

SignalSample Signals::at(std::size_t k, std::int64_t instant, const Drive& drive) const {
  const Source& source = source_[k];
  const NodeTime time = node_time_from_ns(instant * kPeriod_ns);
  const auto value = [&] {
    const double speed_m_s = drive.at(to_seconds(time.time_since_epoch())).speed_m_s;
    switch (source.quantity) {
      case SignalQuantity::kVehicleSpeed:
        return speed_m_s;
      case SignalQuantity::kWheelSpeed:
        return speed_m_s / source.true_radius_m * source.nominal_radius_m;
      case SignalQuantity::kPulseCounter:
        return counter_code(teeth_passed(source, instant, drive), source.counter.modulus,
                            source.counter.step);
      case SignalQuantity::kSteeringAngle:
      case SignalQuantity::kOther:
        break;
    }
    return 0.0;
  };
  return {.time = time, .signal = source.signal, .value = value()};
}

}  // namespace roadbalance::sim
