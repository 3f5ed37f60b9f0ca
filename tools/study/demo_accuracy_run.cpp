#include <functional>
#include <memory>
#include <string>

#include "common/frontend/registry.hpp"
#include "embedded/demo_vehicle.hpp"
#include "firmware/seal_all.hpp"
#include "host/identify/drive_estimator.hpp"
#include "sim/front_end.hpp"
#include "sim/truth.hpp"
#include "tools/study/demo_accuracy.hpp"
#include "tools/study/wheels_json.hpp"

namespace roadbalance {

nlohmann::ordered_json demo_accuracy_run(std::uint64_t seed, double drive_seconds) {
  const auto vehicle = VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml");
  DriveEstimator estimator(vehicle);
  const std::string address =
      "?seed=" + std::to_string(seed) + "&seconds=" + std::to_string(drive_seconds) + "&rate=max";
  for (const NodeConfig& node : vehicle.node) {
    const auto front_end = sim::open_sim_front_end({address, vehicle, node});
    const std::int64_t epoch = node.id;  // any number will do where there is no link
    seal_all(*front_end, vehicle, node, epoch, [&](const SealedBlock& block) { estimator.consume(block); });
  }

  const DriveEstimate& estimate = estimator.estimate();
  auto wheels = wheels_json(estimate.identification, estimate.balance);
  add_truth(wheels, sim::truth_of("", seed, vehicle));
  return {{"seed", seed}, {"wheels", wheels}};
}

}  // namespace roadbalance
