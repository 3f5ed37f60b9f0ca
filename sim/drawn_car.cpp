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

/// Standard deviations of those that no spread draws, as vehicle.toml states them; of the others 0.
ParameterVector sigmas_of(const VehicleConfig& vehicle) {
  ParameterVector sigma = ParameterVector::Zero();
  sigma(kBodyMass) = vehicle.model.body_mass_sigma_kg;
  sigma(kRollInertia) = vehicle.model.roll_inertia_sigma_kg_m2;
  sigma(kPitchInertia) = vehicle.model.pitch_inertia_sigma_kg_m2;
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    sigma(kWheelMass + i) = vehicle.wheel[w].mass_sigma_kg;
    sigma(kTyreDamper + i) = vehicle.model.axle[w / 2].tyre_damper_sigma_n_s_m;
  }
  return sigma;
}

/// The forces of a tyre, of any phase, beside those that the scenario names.
void add_radial_forces(const TyreScenario& tyre, std::uint64_t seed, std::size_t i, WheelScenario& wheel) {
  const RandomSequence random(seed, Use::kRadialForce, i);
  for (std::size_t k = 0; k < tyre.radial_force_n.size(); ++k) {
    const auto counter = 2 * static_cast<std::int64_t>(k);
    const double force_n = random.between(counter, tyre.radial_force_n[k].low, tyre.radial_force_n[k].high);
    const double phase_rad = random.between(counter + 1, 0.0, 2.0 * std::numbers::pi);
    (k == 0 ? wheel.radial_force_n : wheel.higher_radial_force_n[k - 1]) += std::polar(force_n, phase_rad);
  }
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
  car.parameters +=
      scenario.sigma_spread * sigmas_of(vehicle).cwiseProduct(ParameterVector::NullaryExpr(
                                  [&](Eigen::Index p) { return spread.normal(kParameters + p); }));
  // A tyre damper is known by its standard deviation alone, which may be as great as itself.
  car.parameters.segment<kWheels>(kTyreDamper) = car.parameters.segment<kWheels>(kTyreDamper).cwiseMax(0.0);
  const RandomSequence angle(seed, Use::kInitialAngle, 0);
  const auto offset = draw_radius_offsets(seed);
  for (std::size_t i = 0; i < kWheels; ++i) {
    car.rolling_radius_m[i] =
        vehicle.wheel[i].rolling_radius_m * (1.0 + scenario.rolling_radius_spread * offset[i]);
    add_radial_forces(scenario.tyre, seed, i, car.wheel[i]);
    car.initial_angle_rad[i] = 2.0 * std::numbers::pi * angle.uniform(static_cast<std::int64_t>(i));
  }
  return car;
}

}  // namespace roadbalance::sim
