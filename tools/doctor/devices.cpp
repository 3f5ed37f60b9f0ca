#include "tools/doctor/devices.hpp"

#include <exception>

#include "common/frontend/unopened_wiring.hpp"
#include "firmware/backends/front_ends.hpp"
#include "firmware/missing_signals.hpp"
#include "sim/front_end.hpp"

namespace roadbalance {
namespace {

/// Errors of devices end with the remedy.
constexpr const char* kRemedy = "; try: ";

Finding ill(const std::string& name, const std::string& error) {
  const auto at = error.rfind(kRemedy);
  if (at == std::string::npos) return {name, Finding::kIll, error + ".", ""};
  return {name, Finding::kIll, error.substr(0, at) + ".", error.substr(at + std::string(kRemedy).size())};
}

}  // namespace

std::vector<Finding> device_findings(const VehicleConfig& vehicle, const NodeConfig& node) {
  std::vector<Finding> findings;
  FrontEndRegistry front_ends = real_front_ends([&](const std::string& warning) {
    findings.push_back({"device", Finding::kNote, warning + ".", ""});
  });
  front_ends.add("sim", sim::open_sim_front_end);
  for (const std::string& uri : node.wiring.front_end) {
    const std::string what = "node " + node.name + ": " + uri;
    try {
      (void)front_ends.open_device(uri, vehicle, node);
      findings.push_back({uri, Finding::kWell, what + " can be used.", ""});
    } catch (const std::exception& error) {
      findings.push_back(ill(uri, what + ": " + error.what()));
    }
  }
  if (findings.empty())
    findings.push_back(
        {"devices", Finding::kIll, "node " + node.name + " is wired to no device.",
         "rb-node --front-end URI  # or front_end = [\"URI\"] under its [[node]] in the vehicle file"});
  else
    for (const std::string& unread : unopened_wiring(node, node.wiring.front_end))
      findings.push_back(
          {"unopened_wiring", Finding::kIll, unread + ".",
           "front_end = [...]  # with that device, too, under its [[node]] in the vehicle file"});
  for (const std::string& untold : missing_signals(vehicle, node))
    findings.push_back({"missing_signals", Finding::kNote, untold + ".",
                        "[[node.can.signal]] of that quantity, or zero_mark = true and the mark wired"});
  return findings;
}

}  // namespace roadbalance
