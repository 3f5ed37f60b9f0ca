#include "host/orders/wanted_rotors.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

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

[[noreturn]] void refuse_rotor(const VehicleConfig& vehicle, const std::string& name) {
  std::string there;
  for (const RotorConfig& rotor : vehicle.rotor) there += " " + rotor.name;
  throw ConfigError("--rotor " + name + ": there is no such rotor; allowed:" +
                    (there.empty() ? " none: vehicle.toml has no [[rotor]]" : there));
}

[[noreturn]] void refuse_channel(const VehicleConfig& vehicle, const std::string& name) {
  std::string there;
  for (const NodeConfig& node : vehicle.node)
    for (const ChannelConfig& channel : node.channel)
      if (there.find(" " + channel.name + " ") == std::string::npos) there += " " + channel.name + " ";
  throw ConfigError("--channel " + name + ": no node has such a channel; allowed:" + there);
}

std::vector<Rotor> rotors(const VehicleConfig& vehicle, const WantedOrders& wanted) {
  if (wanted.rotor) {
    const RotorConfig* const rotor = vehicle.rotor_named(*wanted.rotor);
    if (!rotor) refuse_rotor(vehicle, *wanted.rotor);
    return {rotor_of(vehicle, *rotor)};
  }
  std::vector<Rotor> all;
  for (const WheelConfig& wheel : vehicle.wheel)
    if (!wheel.node.empty() && (!wanted.wheel || wheel.name == *wanted.wheel))
      all.push_back(rotor_of(vehicle, wheel));
  if (all.empty() && wanted.wheel) refuse_wheel(vehicle, *wanted.wheel);
  if (all.empty())
    throw ConfigError("vehicle.toml of the recording gives no wheel an encoder: no angle, no orders");
  return all;
}

bool reads_encoder(const VehicleConfig& vehicle, const Rotor& rotor, const NodeConfig& node) {
  return std::ranges::any_of(
      rotor.wheel, [&](int w) { return vehicle.wheel[static_cast<std::size_t>(w)].node == node.name; });
}

/// Places of the accelerations in a node's channels.
std::vector<std::size_t> accelerations_of(const NodeConfig& node) {
  std::vector<std::size_t> channels;
  for (std::size_t c = 0; c < node.channel.size(); ++c)
    if (node.channel[c].role == ChannelRole::kAcceleration) channels.push_back(c);
  return channels;
}

struct Place {
  int node;
  std::vector<std::size_t> channel;
};

/// The first of that name, in a node that reads the rotor's encoders if one has it.
std::vector<Place> place_of(const VehicleConfig& vehicle, const Rotor& rotor, const std::string& name) {
  for (const bool own : {true, false})
    for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
      const NodeConfig& node = vehicle.node[n];
      if (reads_encoder(vehicle, rotor, node) != own) continue;
      const auto found = std::ranges::find(node.channel, name, &ChannelConfig::name);
      if (found != node.channel.end())
        return {{static_cast<int>(n), {static_cast<std::size_t>(found - node.channel.begin())}}};
    }
  refuse_channel(vehicle, name);
}

std::vector<Place> places(const VehicleConfig& vehicle, const Rotor& rotor, const WantedOrders& wanted) {
  if (wanted.channel) return place_of(vehicle, rotor, *wanted.channel);
  std::vector<Place> all;
  for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
    if (!wanted.all_nodes && !reads_encoder(vehicle, rotor, vehicle.node[n])) continue;
    auto channels = accelerations_of(vehicle.node[n]);
    if (!channels.empty()) all.push_back({static_cast<int>(n), std::move(channels)});
  }
  return all;
}

}  // namespace

std::vector<std::unique_ptr<RotorOrders>> wanted_rotors(const VehicleConfig& vehicle,
                                                        const WantedOrders& wanted) {
  std::vector<std::unique_ptr<RotorOrders>> all;
  for (const Rotor& rotor : rotors(vehicle, wanted))
    for (Place& place : places(vehicle, rotor, wanted)) try {
        all.push_back(std::make_unique<RotorOrders>(vehicle, rotor, place.node, std::move(place.channel),
                                                    wanted.order));
      } catch (const std::invalid_argument& error) {
        throw ConfigError("--order: " + std::string(error.what()));
      }
  if (all.empty()) throw ConfigError("no node that reads an encoder has a channel of role acceleration");
  return all;
}

}  // namespace roadbalance
