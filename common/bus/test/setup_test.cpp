#include "common/bus/setup.hpp"

#include <gtest/gtest.h>

#include "common/test/source.hpp"
#include "common/types/crc32c.hpp"

namespace roadbalance {
namespace {

TEST(Setup, SaysWhatVehicleTomlSaysOfANode) {
  const auto vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  const NodeConfig& node = vehicle.node.front();
  const auto bytes = encode(setup_of(vehicle, node));
  EXPECT_LT(bytes.size(), 1400U) << "one datagram";
  const auto got = decode_setup(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->node, node.id);
  EXPECT_EQ(got->name, node.name);
  EXPECT_EQ(got->vehicle, vehicle.name.substr(0, 64));
  EXPECT_EQ(got->rate_hz, node.rate_hz);
  EXPECT_EQ(got->filter_order, vehicle.filter.order);
  EXPECT_EQ(got->filter_cutoff_hz, vehicle.filter.cutoff_hz);
  ASSERT_EQ(got->channel.size(), node.channel.size());
  for (std::size_t c = 0; c < node.channel.size(); ++c) {
    const NodeSetup::Channel& channel = got->channel[c];
    EXPECT_EQ(channel.name, node.channel[c].name.substr(0, 32));
    EXPECT_EQ(channel.role, node.channel[c].role);
    const std::string mount =
        channel.mount < 0 ? "body" : kWheelNames.at(static_cast<std::size_t>(channel.mount));
    EXPECT_EQ(mount, node.channel[c].mount);
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      EXPECT_FLOAT_EQ(channel.position_m[k], static_cast<float>(node.channel[c].position_m(axis)));
      EXPECT_FLOAT_EQ(channel.direction[k], static_cast<float>(node.channel[c].direction(axis)));
    }
    EXPECT_FLOAT_EQ(channel.range_m_s2, static_cast<float>(node.channel[c].range_m_s2));
  }
  for (int line = 0; line < kEncoderLines; ++line) {
    const WheelConfig* const wheel = vehicle.wheel_at(node, line);
    const NodeSetup::Encoder& encoder = got->encoder[static_cast<std::size_t>(line)];
    ASSERT_EQ(encoder.wheel, wheel ? vehicle.place_of(*wheel) : -1);
    if (!wheel) continue;
    EXPECT_EQ(encoder.pulses_per_turn, wheel->encoder.pulses_per_turn);
    EXPECT_EQ((encoder.traits & static_cast<int>(EncoderTrait::kZeroMark)) != 0, wheel->encoder.zero_mark);
    EXPECT_EQ(encoder.datum_rad, wheel->encoder.datum_rad);
  }
}

TEST(Setup, TellsFilesOfTwoCarsApart) {
  auto vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  const auto one = setup_of(vehicle, vehicle.node.front()).vehicle_crc32c;
  vehicle.text += " ";
  EXPECT_NE(setup_of(vehicle, vehicle.node.front()).vehicle_crc32c, one);
}

TEST(Setup, RefusesWhatCannotBe) {
  const auto taken = [](auto spoil) {
    NodeSetup sent;
    sent.node = 1;
    sent.channel.resize(1);
    spoil(sent);
    return decode_setup(encode(sent)).has_value();
  };
  EXPECT_TRUE(taken([](NodeSetup&) {}));
  for (const std::int32_t wheel : {-2, kWheels}) {
    EXPECT_FALSE(taken([&](NodeSetup& sent) { sent.channel[0].mount = wheel; })) << wheel;
    EXPECT_FALSE(taken([&](NodeSetup& sent) { sent.encoder[1].wheel = wheel; })) << wheel;
  }
  EXPECT_FALSE(taken([](NodeSetup& sent) { sent.channel[0].role = static_cast<ChannelRole>(3); }));
}

}  // namespace
}  // namespace roadbalance
