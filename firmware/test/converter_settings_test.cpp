#include "firmware/converter_settings.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

using Range = ConverterSettings::Range;

struct ConverterSettingsTest : testing::Test {
  void check(const ConverterSettings& device) { check_change(before, after, "front", device); }
  VehicleConfig before = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  VehicleConfig after = before;
};

TEST_F(ConverterSettingsTest, KnowsWhichDeviceObeys) {
  const auto of = [](std::vector<std::string> addresses) { return converter_settings(addresses); };
  EXPECT_EQ(of({"sim:?seed=1"}).range, Range::kByValue);
  EXPECT_EQ(of({"gpio:gpiochip0", "usb:1209:0001"}).range, Range::kByVoltage);
  EXPECT_EQ(of({"can:can0"}).range, Range::kFixed);
  EXPECT_FALSE(of({"can:can0", "gpio:gpiochip0"}).filter);
  EXPECT_EQ(of({"replay:drive"}).range, Range::kFixed);
}

TEST_F(ConverterSettingsTest, ARangeThatTheDeviceCannotTakeIsRefused) {
  after.node[0].channel[3].range_m_s2 *= 2;
  EXPECT_NO_THROW(check({Range::kByValue, true}));
  EXPECT_THROW(check({Range::kFixed, true}), ConfigError);
  EXPECT_THROW(check({Range::kByVoltage, true}), ConfigError) << "no voltage is told";
  before.node[0].channel[3].input_range_v = after.node[0].channel[3].input_range_v = 5.0;
  EXPECT_THROW(check({Range::kByVoltage, true}), ConfigError) << "the voltage stays";
  after.node[0].channel[3].input_range_v = 10.0;
  EXPECT_NO_THROW(check({Range::kByVoltage, true}));
}

TEST_F(ConverterSettingsTest, AFilterThatTheDeviceCannotSetIsRefused) {
  after.filter.cutoff_hz = 100;
  EXPECT_NO_THROW(check({Range::kFixed, true}));
  EXPECT_THROW(check({Range::kFixed, false}), ConfigError);
}

TEST_F(ConverterSettingsTest, WhatOtherNodesDoIsNoConcern) {
  after.node[1].channel[3].range_m_s2 *= 2;
  EXPECT_NO_THROW(check({Range::kFixed, false}));
}

}  // namespace
}  // namespace roadbalance
