#include "tools/demonstration/demo_start.hpp"

namespace roadbalance {

std::string who_is_idle(const VehicleConfig& vehicle, const BusView& view) {
  for (const NodeConfig& node : vehicle.node) {
    const auto beat = view.heartbeats().find(node.id);
    if (beat == view.heartbeats().end()) return "node " + node.name + " is not heard";
    if (beat->second.owner == 0 && !beat->second.is_over()) return "no recorder claims node " + node.name;
  }
  if (!view.identification() && view.levels().empty()) return "no analyser is heard";
  return "";
}

}  // namespace roadbalance
