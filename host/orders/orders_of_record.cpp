#include "host/orders/orders_of_record.hpp"

#include <stdexcept>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

[[noreturn]] void refuse_wheel(const VehicleConfig& vehicle, const std::string& name) {
  const char* why = ": there is no such wheel";
  std::string there;
  for (const WheelConfig& wheel : vehicle.wheel) {
    if (!wheel.node.empty()) there += " " + wheel.name;
    if (wheel.name == name) why = ": vehicle.toml gives it no encoder";
  }
  throw ConfigError("--wheel " + name + why + "; allowed:" + (there.empty() ? " none" : there));
}

std::vector<std::size_t> accelerations_of(const NodeConfig& node) {
  std::vector<std::size_t> channels;
  for (std::size_t c = 0; c < node.channel.size(); ++c)
    if (node.channel[c].role == ChannelRole::kAcceleration) channels.push_back(c);
  return channels;
}

/// Place of the channel in the node; nothing if it has none of that name.
std::vector<std::size_t> channel_named(const NodeConfig& node, const std::string& name) {
  for (std::size_t c = 0; c < node.channel.size(); ++c)
    if (node.channel[c].name == name) return {c};
  return {};
}

[[noreturn]] void refuse_channel(const VehicleConfig& vehicle, const WantedOrders& wanted) {
  std::string there;
  for (const WheelConfig& wheel : vehicle.wheel) {
    if (wheel.node.empty() || (wanted.wheel && wheel.name != *wanted.wheel)) continue;
    for (const ChannelConfig& channel : vehicle.node_named(wheel.node).channel)
      if (there.find(" " + channel.name + " ") == std::string::npos) there += " " + channel.name + " ";
  }
  throw ConfigError("--channel " + *wanted.channel + ": no node that reads " +
                    (wanted.wheel ? "that wheel's" : "an") + " encoder has such a channel; allowed:" + there);
}

std::vector<std::unique_ptr<WheelOrders>> analyses(const VehicleConfig& vehicle, const WantedOrders& wanted) {
  std::vector<std::unique_ptr<WheelOrders>> all;
  bool any_wheel = false;
  for (const WheelConfig& wheel : vehicle.wheel) {
    if (wheel.node.empty() || (wanted.wheel && wheel.name != *wanted.wheel)) continue;
    any_wheel = true;
    const NodeConfig& node = vehicle.node_named(wheel.node);
    auto channels = wanted.channel ? channel_named(node, *wanted.channel) : accelerations_of(node);
    if (channels.empty()) continue;
    try {
      all.push_back(std::make_unique<WheelOrders>(vehicle, wheel, std::move(channels), wanted.order));
    } catch (const std::invalid_argument& error) {
      throw ConfigError("--order: " + std::string(error.what()));
    }
  }
  if (!any_wheel && wanted.wheel) refuse_wheel(vehicle, *wanted.wheel);
  if (!any_wheel)
    throw ConfigError("vehicle.toml of the recording gives no wheel an encoder: no angle, no orders");
  if (all.empty() && wanted.channel) refuse_channel(vehicle, wanted);
  if (all.empty()) throw ConfigError("no node that reads an encoder has a channel of role acceleration");
  return all;
}

}  // namespace

RecordOrders orders_of_record(const std::filesystem::path& folder, const WantedOrders& wanted) {
  RecordOrders result;
  result.defects = read_recording(
      folder, [&](const VehicleConfig& vehicle) { result.wheel = analyses(vehicle, wanted); },
      [&](const SealedBlock& block) {
        for (const auto& wheel : result.wheel) wheel->consume(block);
      });
  return result;
}

}  // namespace roadbalance
