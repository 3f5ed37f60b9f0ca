#include "firmware/describe.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <thread>

#include "common/bus/bus.hpp"
#include "common/bus/setup.hpp"
#include "common/test/bus_url.hpp"
#include "common/test/source.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;

TEST(Describe, SaysWhatTheNodeIsAgainAndAgain) {
  const auto vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  const NodeConfig& node = vehicle.node.back();
  const std::string url = test::bus_url();
  Bus bus(url);
  int heard = 0;
  std::optional<NodeSetup> setup;
  bus.subscribe("RB_SETUP_.*", [&](std::string_view channel, std::span<const std::uint8_t> bytes) {
    EXPECT_EQ(channel, setup_channel(node.id));
    setup = decode_setup(bytes);
    ++heard;
  });
  const std::jthread process([&](const std::stop_token& stop) { describe(stop, url, vehicle, node); });
  // Not a limit of the product's: a test that receives nothing has to end.
  for (const auto end = WallClock::now() + 60s; heard < 2 && WallClock::now() < end;) bus.handle(100ms);
  ASSERT_GE(heard, 2);
  ASSERT_TRUE(setup);
  EXPECT_EQ(setup->name, node.name);
  EXPECT_EQ(setup->channel.size(), node.channel.size());
}

}  // namespace
}  // namespace roadbalance
