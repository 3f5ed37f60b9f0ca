#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/frontend/registry.hpp"
#include "common/process/channel.hpp"
#include "common/process/parallel.hpp"
#include "embedded/demo_vehicle.hpp"
#include "firmware/seal_all.hpp"
#include "host/identify/drive_estimator.hpp"
#include "sim/front_end.hpp"
#include "sim/truth.hpp"
#include "tools/study/demo_accuracy.hpp"
#include "tools/study/wheels_json.hpp"

namespace roadbalance {

nlohmann::ordered_json demo_accuracy_run(std::uint64_t seed, double drive_seconds,
                                         const std::vector<double>& converter_ppm) {
  const auto vehicle = VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml");
  DriveEstimator estimator(vehicle);
  const std::string address =
      "?seed=" + std::to_string(seed) + "&seconds=" + std::to_string(drive_seconds) + "&rate=max";
  Parallel nodes;  // side by side, so that no node's blocks pile up while they wait for another's
  std::vector<In<SealedBlock>> blocks;
  for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
    const NodeConfig& node = vehicle.node[n];
    std::string its_address = address;
    if (n < converter_ppm.size()) its_address += "&converter_ppm=" + std::to_string(converter_ppm[n]);
    auto [out, in] = make_channel<SealedBlock>(64);
    blocks.push_back(std::move(in));
    nodes.run(
        [its_address, &vehicle, &node](Out<SealedBlock> sealed) {
          const auto front_end = sim::open_sim_front_end({its_address, vehicle, node});
          const std::int64_t epoch = node.id;  // any number will do where there is no link
          seal_all(*front_end, vehicle, node, epoch, [&](const SealedBlock& block) { sealed.send(block); });
        },
        std::move(out));
  }
  for (bool more = true; std::exchange(more, false);)
    for (auto& in : blocks)
      if (const auto block = in.receive()) {
        estimator.consume(*block);
        more = true;
      }
  nodes.wait();

  const DriveEstimate& estimate = estimator.estimate();
  auto wheels = wheels_json(estimate.identification, estimate.balance);
  add_truth(wheels, sim::truth_of("", seed, vehicle));
  return {{"seed", seed}, {"wheels", wheels}};
}

}  // namespace roadbalance
