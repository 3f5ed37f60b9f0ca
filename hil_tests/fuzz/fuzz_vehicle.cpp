#include <optional>
#include <span>
#include <string>

#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/crc32c.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/analysis/balance/weight_plan.hpp"
#include "host/recorder/control/vehicle_edit.hpp"

namespace roadbalance {
namespace {

using fuzz::require;

fuzz::Reached ranges("a range that is changed"), filters("a filter that is changed");

// The text as it comes back from a request, or nothing if that is refused.
std::optional<VehicleConfig> changed(auto&& change) {
  std::string text;
  try {
    text = change();
  } catch (const ConfigError& error) {
    require(error.what()[0] != 0, "a refusal says why");
    return std::nullopt;
  }
  return VehicleConfig::parse(text, "changed.toml");
}

// However its user wrote it, one value changes, and no other channel or node does.
void check_changes(const VehicleConfig& vehicle) {
  const std::uint32_t chance =
      crc32c(std::span(reinterpret_cast<const std::uint8_t*>(vehicle.text.data()), vehicle.text.size()));
  const std::size_t n = chance % vehicle.node.size(), c = chance / 64 % vehicle.node[n].channel.size();
  const double range = 1.0 + chance / 4096 % 1000 * 0.5;
  const auto other_range = changed([&] {
    return with_range(vehicle.text, {.operation = Operation::kRange,
                                     .node = vehicle.node[n].id,
                                     .channel = static_cast<std::int32_t>(c),
                                     .value = {range, 0}});
  });
  if (other_range) {
    ranges.count();
    require(other_range->node.size() == vehicle.node.size(), "no node comes or goes");
    for (std::size_t k = 0; k < vehicle.node.size(); ++k) {
      const NodeConfig &is = other_range->node[k], &was = vehicle.node[k];
      require(is.id == was.id && is.name == was.name && is.channel.size() == was.channel.size(),
              "a node stays what it is");
      for (std::size_t m = 0; m < was.channel.size(); ++m) {
        const double wanted = k == n && m == c ? range : was.channel[m].range_m_s2;
        require(is.channel[m].range_m_s2 == wanted, "one range is changed, and no other");
        require(is.channel[m].name == was.channel[m].name, "channels keep their names");
        require((k == n && m == c) ||
                    (is.channel[m].scale_m_s2_per_count == was.channel[m].scale_m_s2_per_count &&
                     is.channel[m].offset_counts == was.channel[m].offset_counts),
                "and their calibrations");
      }
    }
  }
  const double cutoff_hz = 10.0 + chance % 200;
  const auto other_filter = changed([&] {
    return with_filter(vehicle.text, {.operation = Operation::kFilter, .value = {cutoff_hz, 0}});
  });
  if (other_filter) {
    filters.count();
    require(other_filter->filter.cutoff_hz == cutoff_hz && other_filter->filter.order == vehicle.filter.order,
            "the filter is the one that was asked for");
  }
}

}  // namespace
}  // namespace roadbalance

// vehicle.toml: refused with an error that names the file, or within all bounds that the rest relies on, and
// changed by requests.
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
    check_changes(vehicle);
  } catch (const ConfigError& error) {
    require(std::string(error.what()).starts_with("fuzz.toml"), "an error names the file");
  }
  return 0;
}
