#include "sim/truth.hpp"

#include <cmath>
#include <numbers>

namespace roadbalance::sim {

Truth truth_of(const std::string& scenario_path, std::uint64_t seed, const VehicleConfig& vehicle) {
  Truth truth{{}, draw_car(Scenario::read(scenario_path, vehicle, seed), seed, vehicle)};
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::complex<double> unbalance = truth.car.wheel[i].unbalance_kg_m;
    const double angle_deg = std::arg(unbalance) * 180.0 / std::numbers::pi;
    truth.wheel[i] = {1e3 * std::abs(unbalance) / vehicle.wheel[i].weight_radius_m,
                      angle_deg < 0.0 ? angle_deg + 360.0 : angle_deg,
                      truth.car.parameters(kTyre + static_cast<int>(i)),
                      std::abs(truth.car.wheel[i].radial_force_n)};
  }
  return truth;
}

}  // namespace roadbalance::sim
