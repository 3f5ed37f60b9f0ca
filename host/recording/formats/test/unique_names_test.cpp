#include "host/recording/formats/unique_names.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace roadbalance {
namespace {

using Names = std::vector<std::string>;

/// Names of all channels of nodes "front" and "rear".
Names made_of(const Names& front, const Names& rear, const std::string& unused = "") {
  VehicleConfig vehicle{};
  for (const auto& [node, names] : {std::pair{"front", front}, {"rear", rear}}) {
    vehicle.node.push_back({.name = node, .id = 1, .rate_hz = 500.0, .channel = {}});
    for (const std::string& name : names) {
      ChannelConfig channel;
      channel.name = name;
      if (name == unused) channel.role = ChannelRole::kUnused;
      vehicle.node.back().channel.push_back(channel);
    }
  }
  Names made;
  for (const NodeConfig& node : with_unique_names(vehicle).node)
    for (const ChannelConfig& channel : node.channel) made.push_back(channel.name);
  return made;
}

TEST(UniqueNames, KeepsWhatIsUnique) {
  EXPECT_EQ(made_of({"front_up", "a.b"}, {"rear_up", "c"}), (Names{"front_up", "a.b", "rear_up", "c"}));
}

TEST(UniqueNames, PutsTheNodeBeforeANameThatTwoHave) {
  EXPECT_EQ(made_of({"up", "side"}, {"up", "long"}), (Names{"front_up", "side", "rear_up", "long"}));
}

TEST(UniqueNames, TakesNamesForAlikeThatAFormatWouldMakeAlike) {
  EXPECT_EQ(made_of({"up.z"}, {"Up_z"}), (Names{"front_up.z", "rear_Up_z"}));
  EXPECT_EQ(made_of({"up.z", "up_z"}, {}), (Names{"front_up.z", "front_up_z_"}));
}

TEST(UniqueNames, TakesNobodysName) {
  EXPECT_EQ(made_of({"up"}, {"up", "front_up"}), (Names{"front_up_", "rear_up", "front_up"}));
}

TEST(UniqueNames, LeavesUnusedChannelsAlone) {
  EXPECT_EQ(made_of({"front_up", "spare"}, {"rear_up", "spare"}, "spare"),
            (Names{"front_up", "spare", "rear_up", "spare"}));
}

}  // namespace
}  // namespace roadbalance
