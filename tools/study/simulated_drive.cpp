#include "tools/study/simulated_drive.hpp"

#include <memory>
#include <utility>

#include "common/frontend/registry.hpp"
#include "common/process/channel.hpp"
#include "common/process/parallel.hpp"
#include "firmware/epoch_packer.hpp"
#include "host/analysis/identify/drive_estimator.hpp"
#include "sim/front_end.hpp"

namespace roadbalance {

void simulate_drive(const VehicleConfig& vehicle, const std::string& address,
                    const std::vector<double>& converter_ppm,
                    const std::function<void(const SealedBlock&)>& consume) {
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
          pack_epoch(*front_end, vehicle, node, epoch, [&](const SealedBlock& block) { sealed.send(block); });
        },
        std::move(out));
  }
  for (bool more = true; std::exchange(more, false);)
    for (auto& in : blocks)
      if (const auto block = in.receive()) {
        consume(*block);
        more = true;
      }
  nodes.wait();
}

DriveEstimate identify_simulated_drive(const VehicleConfig& vehicle, const std::string& address,
                                       const std::vector<double>& converter_ppm) {
  DriveEstimator estimator(vehicle);
  simulate_drive(vehicle, address, converter_ppm,
                 [&](const SealedBlock& block) { estimator.consume(block); });
  return estimator.estimate();
}

}  // namespace roadbalance
