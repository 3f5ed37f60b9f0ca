#include <string>

#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/balance/weight_plan.hpp"

// vehicle.toml: refused with an error that names the file, or within all bounds that the rest relies on.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  using fuzz::require;
  const std::string text(reinterpret_cast<const char*>(data), size);
  static fuzz::Reached vehicles("a vehicle"), plans("a plan of weights"), wirings("a wired node");
  try {
    const VehicleConfig vehicle = VehicleConfig::parse(text, "fuzz.toml");
    require(vehicle.text == text, "the text is kept as it was read");
    require(!vehicle.node.empty(), "a vehicle has a node");
    for (const NodeConfig& node : vehicle.node) {
      require(node.id >= 1 && node.id <= 9999, "a node's number is in bounds");
      require(node.rate_hz > 0 && node.rate_hz == vehicle.node[0].rate_hz, "nodes share one positive rate");
      require(!node.channel.empty() && node.channel.size() <= kAccelerations, "a node has 1 to 12 channels");
      require(vehicle.node_with_id(node.id) == &node, "numbers of nodes are unique");
      require(&vehicle.node_named(node.name) == &node, "names of nodes are unique");
      for (int line = 0; line < kEncoderLines; ++line)
        if (const WheelConfig* const wheel = vehicle.wheel_at(node, line))
          require(vehicle.wheel_named(wheel->name) == wheel, "an encoder is on one of the wheels");
    }
    vehicles.count();
    for (const NodeConfig& node : vehicle.node)
      if (!node.wiring.can.empty()) wirings.count();
    for (const WheelConfig& wheel : vehicle.wheel) {
      const auto steps = plan_weights({3.0, 4.0}, 0.1, wheel.stock, wheel.fitted).step.size();
      require(steps <= kMostWeightSteps, "every stock of weights makes a plan that a message holds");
      if (steps > 0) plans.count();
    }
  } catch (const ConfigError& error) {
    require(std::string(error.what()).starts_with("fuzz.toml"), "an error names the file");
  }
  return 0;
}
