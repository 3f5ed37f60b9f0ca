#include "host/analysis/twin/twin_car.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {

TwinCar TwinCar::nominal(const VehicleConfig& vehicle) {
  TwinCar car{.geometry = geometry_of(vehicle.model), .parameters = nominal_parameters(vehicle)};
  for (std::size_t w = 0; w < kWheels; ++w) car.rolling_radius_m[w] = vehicle.wheel[w].rolling_radius_m;
  return car;
}

TwinCar TwinCar::estimated(const VehicleConfig& vehicle, const Identification& identification,
                           std::span<const Balance> balance) {
  TwinCar car = nominal(vehicle);
  const auto put = [&](int first, const auto& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      car.parameters(first + static_cast<Eigen::Index>(i)) = values[i];
  };
  const auto positive = [](const auto& values) {
    return std::ranges::all_of(values, [](double value) { return std::isfinite(value) && value > 0.0; });
  };
  // One that a car does not have may come out a little below 0.
  const auto finite = [](const auto& values) {
    return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
  };
  const Identification& i = identification;
  car.identified = i.state == Unknown::kNone && positive(i.spring_n_m) && positive(i.damper_n_s_m) &&
                   finite(i.stabiliser_n_m) && positive(i.tyre_n_m);
  if (car.identified) {
    put(kSpring, i.spring_n_m);
    put(kDamper, i.damper_n_s_m);
    put(kStabiliser, i.stabiliser_n_m);
    put(kTyre, i.tyre_n_m);
  }
  for (const Balance& one : balance) {
    if (one.state != Unknown::kNone || one.wheel < 0 || one.wheel >= kWheels) continue;
    if (!std::isfinite(one.unbalance_g) || one.unbalance_g < 0.0 || !std::isfinite(one.angle_rad)) continue;
    const auto w = static_cast<std::size_t>(one.wheel);
    car.unbalance_kg_m[w] =
        std::polar(1e-3 * one.unbalance_g * vehicle.wheel[w].weight_radius_m, one.angle_rad);
    car.balance[w] = true;
  }
  return car;
}

double greatest_difference(const TwinCar& a, const TwinCar& b) {
  double greatest = 0.0;
  for (int p = kSpring; p < kTyreDamper; ++p) {
    const bool is_stabiliser = kStabiliser <= p && p < kTyre;
    const double scale =
        is_stabiliser ? b.parameters.segment<2>(kSpring + 2 * (p - kStabiliser)).mean() : b.parameters(p);
    greatest = std::max(greatest, std::abs(a.parameters(p) - b.parameters(p)) / scale);
  }
  return greatest;
}

}  // namespace roadbalance
