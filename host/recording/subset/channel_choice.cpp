#include "host/recording/subset/channel_choice.hpp"

#include <algorithm>
#include <cmath>

#include "common/config/section.hpp"
#include "common/config/set_value.hpp"
#include "host/recording/subset/reduction.hpp"

namespace roadbalance {
namespace {

constexpr const char* kName = "vehicle.toml of the subset";
constexpr std::uint32_t kAllReferences = ((1U << kReferences) - 1) << kAccelerations;

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string with_rate(std::string text, const VehicleConfig& vehicle, int factor) {
  const double rate_hz = vehicle.node.front().rate_hz / factor;
  if (factor > largest_reduction(vehicle))
    throw ConfigError("--factor, --rate: " + toml_number(rate_hz, 3) +
                      " Hz are left; allowed: more than twice the " +
                      toml_number(vehicle.filter.cutoff_hz, 3) + " Hz of [filter] cutoff_hz");
  const double identified_hz = vehicle.drive.identification_rate_hz;
  const double steps = rate_hz / identified_hz;
  constexpr int kDecimals = 9;
  constexpr double kLeastIdentified_hz = 50.0;  // least that vehicle.toml allows
  const std::string rate = toml_number(rate_hz, kDecimals);
  if (rate_hz >= kLeastIdentified_hz && (steps < 1.0 || std::abs(steps - std::round(steps)) > 1e-9))
    text = with_value(text, {{"drive"}}, "identification_rate_hz", rate, kName);
  for (const NodeConfig& node : vehicle.node)
    text = with_value(text, {{"node", node.name}}, "rate_hz", rate, kName);
  return text;
}

}  // namespace

void check_choice(const ChannelChoice& choice, const VehicleConfig& vehicle) {
  std::vector<std::string> nodes, channels;
  std::string all_nodes, all;
  for (const NodeConfig& node : vehicle.node) {
    nodes.push_back(node.name);
    channels.push_back(node.name);
    all_nodes += " " + node.name;
    for (const ChannelConfig& channel : node.channel) {
      channels.push_back(channel.name);
      all += " " + channel.name;
    }
  }
  for (const auto& name : choice.nodes)
    if (!holds(nodes, name)) throw ConfigError("--nodes: " + name + ": no such node; allowed:" + all_nodes);
  for (const auto& name : choice.channels)
    if (!holds(channels, name))
      throw ConfigError("--channels: " + name + ": no such channel or node; allowed:" + all_nodes + all);
  if (std::none_of(vehicle.node.begin(), vehicle.node.end(),
                   [&](const NodeConfig& node) { return chosen_channels(choice, node) != 0; }))
    throw ConfigError("--nodes, --channels: no channel is in both");
}

std::uint32_t chosen_channels(const ChannelChoice& choice, const NodeConfig& node) {
  if (!choice.nodes.empty() && !holds(choice.nodes, node.name)) return 0;
  std::uint32_t chosen = 0;
  const bool all = choice.channels.empty() || holds(choice.channels, node.name);
  for (std::size_t k = 0; k < node.channel.size(); ++k)
    if (all || holds(choice.channels, node.channel[k].name)) chosen |= 1U << k;
  return chosen == 0 ? 0 : chosen | kAllReferences;
}

std::string subset_vehicle(const std::string& text, const ChannelChoice& choice, int factor) {
  const VehicleConfig vehicle = VehicleConfig::parse(text, "vehicle.toml of the recording");
  std::string changed = text;
  for (const NodeConfig& node : vehicle.node) {
    const std::uint32_t chosen = chosen_channels(choice, node);
    if (chosen == 0) continue;  // it stays as it was, without samples
    for (std::size_t k = 0; k < node.channel.size(); ++k)
      if ((chosen >> k & 1) == 0 && node.channel[k].role != ChannelRole::kUnused)
        changed = with_value(changed, {{"node", node.name}, {"channel", node.channel[k].name}}, "role",
                             "\"unused\"", kName);
  }
  if (factor > 1) changed = with_rate(std::move(changed), vehicle, factor);
  if (changed != text) VehicleConfig::parse(changed, kName);
  return changed;
}

}  // namespace roadbalance
