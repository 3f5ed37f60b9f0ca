#include "sim/drawn_car.hpp"

#include <algorithm>
#include <numbers>

#include "common/config/section.hpp"
#include "sim/random.hpp"

namespace roadbalance::sim {
namespace {

/// The four wheels take the places -1, -1/3, 1/3, 1 in random order, each moved by up to 1/12.
std::array<double, kWheels> draw_radius_offsets(std::uint64_t seed) {
  const RandomSequence random(seed, Use::kRollingRadius, 0);
  std::array<double, kWheels> offset{};
  for (std::size_t i = 0; i < kWheels; ++i)
    offset[i] = (static_cast<double>(i) * 2.0 / 3.0 - 1.0) +
                (random.uniform(static_cast<std::int64_t>(i)) - 0.5) / 6.0;
  for (std::size_t i = kWheels - 1; i > 0; --i)
    std::swap(offset[i], offset[random.bits(static_cast<std::int64_t>(kWheels + i)) % (i + 1)]);
  return offset;
}

}  // namespace

DrawnCar draw_car(const Scenario& scenario, std::uint64_t seed, const VehicleConfig& vehicle) {
  if (!vehicle.model.description.empty())
    throw ConfigError("vehicle " + vehicle.name +
                      ": kind of [model] is \"description\"; the simulated car is a \"seven_dof\" only");
  DrawnCar car{geometry_of(vehicle.model), nominal_parameters(vehicle), {}, {}, scenario.wheel};
  const RandomSequence spread(seed, Use::kParameters, 0);
  for (int p = kSpring; p < kParameters; ++p)
    car.parameters(p) *= 1.0 + scenario.parameter_spread * (2.0 * spread.uniform(p) - 1.0);
  const RandomSequence angle(seed, Use::kInitialAngle, 0);
  const auto offset = draw_radius_offsets(seed);
  for (std::size_t i = 0; i < kWheels; ++i) {
    car.rolling_radius_m[i] =
        vehicle.wheel[i].rolling_radius_m * (1.0 + scenario.rolling_radius_spread * offset[i]);
    car.initial_angle_rad[i] = 2.0 * std::numbers::pi * angle.uniform(static_cast<std::int64_t>(i));
  }
  return car;
}

}  // namespace roadbalance::sim
