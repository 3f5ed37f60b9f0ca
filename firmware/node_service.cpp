#include "firmware/node_service.hpp"

#include <exception>
#include <utility>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

/// As the recorder sent it; the files that it names lie where those of the one before do.
VehicleConfig parse_wanted(const std::string& text, const VehicleConfig& before,
                           const std::string& node_name) {
  VehicleConfig vehicle = VehicleConfig::parse(text, "vehicle.toml");
  vehicle.folder = before.folder;
  const NodeConfig& node = vehicle.node_named(node_name);
  if (const int id = before.node_named(node_name).id; node.id != id)
    throw ConfigError("node " + node_name + ": its id was " + std::to_string(id) + " and cannot become " +
                      std::to_string(node.id) + " while it runs");
  return vehicle;
}

/// Puts the wanted vehicle.toml in force, or leaves the one that is.
void change_vehicle(VehicleChange& change, VehicleConfig& vehicle, const std::string& node_name,
                    const OpenFrontEnd& open, const ConverterSettings& device,
                    std::unique_ptr<FrontEnd>& front_end) {
  try {
    VehicleConfig wanted = parse_wanted(*change.wanted(), vehicle, node_name);
    check_change(vehicle, wanted, node_name, device);
    front_end.reset();  // a device can be open once
    front_end = open(wanted, wanted.node_named(node_name));
    vehicle = std::move(wanted);
    change.made();
  } catch (const std::exception& error) {
    change.refused(error.what());
    if (!front_end) front_end = open(vehicle, vehicle.node_named(node_name));
  }
}

}  // namespace

std::int64_t serve_node(std::stop_token stop, VehicleConfig vehicle, const std::string& node_name,
                        const OpenFrontEnd& open, const ConverterSettings& device, bool stays,
                        const NodeOptions& options) {
  VehicleChange change(vehicle.text, true);
  auto front_end = open(vehicle, vehicle.node_named(node_name));
  std::int64_t lost = 0;
  for (bool is_first = true;; is_first = false) {
    const EpochResult epoch =
        run_epoch(stop, vehicle, vehicle.node_named(node_name), *front_end, options, change, is_first);
    lost += epoch.lost;
    const bool goes_on = !stop.stop_requested() && !epoch.device_ended;
    if (!goes_on || (!stays && !change.wanted())) return lost;
    if (change.wanted()) change_vehicle(change, vehicle, node_name, open, device, front_end);
  }
}

}  // namespace roadbalance
