#include "firmware/missing_signals.hpp"

#include "common/angle/wanted_signal.hpp"

namespace roadbalance {

std::vector<std::string> missing_signals(const VehicleConfig& vehicle, const NodeConfig& node) {
  std::vector<std::string> missing;
  for (const WheelConfig& wheel : vehicle.wheel) {
    if (wheel.node != node.name) continue;
    if (wheel.encoder.steering_ratio != 0.0 && !steering_signal(node.wiring))
      missing.push_back(
          wheel.name +
          ": its encoder gains when the car steers, and no signal of quantity steering_angle of node " +
          node.name + " tells by how much: its angle stays uncertain");
    if (!wheel.encoder.counter.empty() && !wheel.encoder.zero_mark)
      missing.push_back(wheel.name +
                        ": its teeth are counted on the bus, and it has no zero mark: there will be no "
                        "angle, only magnitudes of what turns with it");
  }
  return missing;
}

}  // namespace roadbalance
