#include <string>
#include <vector>

#include "embedded/demo_vehicle.hpp"
#include "sim/truth.hpp"
#include "tools/study/demo_accuracy.hpp"
#include "tools/study/simulated_drive.hpp"
#include "tools/views/wheels_json.hpp"

namespace roadbalance {

nlohmann::ordered_json demo_accuracy_run(std::uint64_t seed, double drive_seconds,
                                         const std::vector<double>& converter_ppm) {
  const auto vehicle = VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml");
  const DriveEstimate estimate = identify_simulated_drive(
      vehicle, "?seed=" + std::to_string(seed) + "&seconds=" + std::to_string(drive_seconds) + "&rate=max",
      converter_ppm);
  auto wheels = wheels_json(estimate.identification, estimate.balance);
  add_truth(wheels, sim::truth_of("", seed, vehicle));
  return {{"seed", seed}, {"wheels", wheels}};
}

}  // namespace roadbalance
