#include "host/analysis/orders/rotor.hpp"

#include <cmath>
#include <numbers>

namespace roadbalance {

double Rotor::way_m(const VehicleConfig& vehicle) const {
  double radius_m = 0.0;
  for (const int w : wheel)
    radius_m +=
        vehicle.wheel[static_cast<std::size_t>(w)].rolling_radius_m / static_cast<double>(wheel.size());
  return 2.0 * std::numbers::pi * radius_m / ratio;
}

double Rotor::class_hz(const VehicleConfig& vehicle) const {
  return vehicle.drive.speed_class_m_s / way_m(vehicle);
}

Rotor rotor_of(const VehicleConfig& vehicle, const WheelConfig& wheel) {
  return {wheel.name, {vehicle.place_of(wheel)}, 1.0, wheel.encoder.zero_mark ? 1.0 : 0.0};
}

Rotor rotor_of(const VehicleConfig& vehicle, const RotorConfig& rotor) {
  bool marked = true;
  for (const int w : rotor.wheel)
    marked = marked && vehicle.wheel[static_cast<std::size_t>(w)].encoder.zero_mark;
  const double share = marked ? known_share(rotor.ratio, static_cast<int>(rotor.wheel.size())) : 0.0;
  return {rotor.name, rotor.wheel, rotor.ratio, share};
}

double known_share(double ratio, int wheels) {
  const double of_a_turn = ratio / wheels;
  for (int q = 1; q <= kLargestDenominator; ++q) {
    const double p = std::round(of_a_turn * q);
    if (p >= 1.0 && std::abs(of_a_turn - p / q) <= 1e-9 * of_a_turn) return 1.0 / q;
  }
  return 0.0;
}

}  // namespace roadbalance
