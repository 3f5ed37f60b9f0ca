#include "host/recording/formats/unique_names.hpp"

#include <cctype>
#include <map>
#include <set>
#include <string>

#include "host/recording/formats/candump_writer.hpp"

namespace roadbalance {
namespace {

/// The same for names that are alike.
std::string plain_name(const std::string& name) {
  std::string plain = dbc_identifier(name);
  for (char& c : plain) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return plain;
}

}  // namespace

VehicleConfig with_unique_names(VehicleConfig vehicle) {
  std::map<std::string, int> times;
  for (const NodeConfig& node : vehicle.node)
    for (const ChannelConfig& channel : node.channel)
      if (channel.role != ChannelRole::kUnused) ++times[plain_name(channel.name)];
  std::set<std::string> taken;
  for (const auto& [name, count] : times)
    if (count == 1) taken.insert(name);
  for (NodeConfig& node : vehicle.node)
    for (ChannelConfig& channel : node.channel) {
      if (channel.role == ChannelRole::kUnused || times.at(plain_name(channel.name)) == 1) continue;
      channel.name = node.name + "_" + channel.name;
      while (!taken.insert(plain_name(channel.name)).second) channel.name += '_';
    }
  return vehicle;
}

}  // namespace roadbalance
