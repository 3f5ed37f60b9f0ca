#include "firmware/describe.hpp"

#include <chrono>
#include <exception>
#include <optional>

#include "common/bus/bus.hpp"
#include "common/bus/setup.hpp"
#include "common/process/pause.hpp"

namespace roadbalance {

void describe(std::stop_token stop, const std::string& bus_url, const VehicleConfig& vehicle,
              const NodeConfig& node) {
  const std::string channel = setup_channel(node.id);
  const auto setup = encode(setup_of(vehicle, node));
  std::optional<Bus> bus;
  do {
    try {
      if (!bus) bus.emplace(bus_url);
      bus->publish(channel, setup);
    } catch (const std::exception&) {
      bus.reset();
    }
  } while (pause(stop, std::chrono::seconds(1)));
}

}  // namespace roadbalance
