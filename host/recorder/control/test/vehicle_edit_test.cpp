#include "host/recorder/control/vehicle_edit.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

std::string demo_text() {
  return test::read_source("sim/demo/vehicle.toml");
}

VehicleConfig parse(const std::string& text) {
  return VehicleConfig::parse(text, "test");
}

Request range(int node, int channel, double m_s2) {
  return {.operation = Operation::kRange, .node = node, .channel = channel, .value = {m_s2, 0}};
}

TEST(VehicleEdit, ARangeChangesItsChannelAlone) {
  const std::string before = demo_text();
  const std::string text = with_range(before, range(2, 4, 100));
  const VehicleConfig vehicle = parse(text);
  EXPECT_EQ(vehicle.node[1].channel[4].range_m_s2, 100);
  EXPECT_NEAR(vehicle.node[1].channel[4].scale_m_s2_per_count * (1 << 23), 100, 1e-9);
  EXPECT_EQ(vehicle.node[0].channel[4].range_m_s2, 50);
  EXPECT_EQ(vehicle.node[1].channel[3].range_m_s2, 50);
  EXPECT_NEAR(static_cast<double>(text.size()), static_cast<double>(before.size()), 4) << "all else stays";
}

// The same acceleration is the same volts: twice the range is half the counts, and twice the voltage.
TEST(VehicleEdit, ARangeTakesAlongWhatGoesWithIt) {
  std::string text = demo_text();
  const std::string key = "name = \"fl_carrier_z\"\n";
  text.insert(
      text.find(key) + key.size(),
      "input_range_v = 5.0\ncalibration = { scale_m_s2_per_count = 0.00003, offset_counts = -1000.0 }\n");
  const ChannelConfig before = parse(text).node[0].channel[2];
  const ChannelConfig after = parse(with_range(text, range(1, 2, 400))).node[0].channel[2];
  EXPECT_EQ(after.range_m_s2, 400);
  EXPECT_DOUBLE_EQ(*after.input_range_v, 10.0);
  EXPECT_DOUBLE_EQ(after.scale_m_s2_per_count, 0.00006);
  EXPECT_DOUBLE_EQ(after.offset_counts, -500);
  // A reading of 3 m/s² stays one of 3 m/s².
  const double counts_before = 3.0 / before.scale_m_s2_per_count + before.offset_counts;
  EXPECT_NEAR(after.to_si(counts_before / 2), before.to_si(counts_before), 1e-9);
}

TEST(VehicleEdit, RefusesWhatIsNotThere) {
  EXPECT_THROW(with_range(demo_text(), range(9, 0, 100)), ConfigError);
  EXPECT_THROW(with_range(demo_text(), range(1, -1, 100)), ConfigError);
  EXPECT_THROW(with_range(demo_text(), range(1, 0, 0)), ConfigError);
  EXPECT_THROW(with_range(demo_text(), range(1, 0, -5)), ConfigError);
}

TEST(VehicleEdit, AFilterKeepsItsOrderUnlessAskedOtherwise) {
  Request request{.operation = Operation::kFilter, .value = {150, 0}};
  EXPECT_EQ(parse(with_filter(demo_text(), request)).filter.cutoff_hz, 150);
  EXPECT_EQ(parse(with_filter(demo_text(), request)).filter.order, 6);
  request.value[1] = 4;
  EXPECT_EQ(parse(with_filter(demo_text(), request)).filter.order, 4);
}

TEST(VehicleEdit, ADatumIsOfItsWheel) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  const Request request{
      .operation = Operation::kDatum, .channel = 1, .value = {-107.125 * kDegree, 0.401 * kDegree}};
  const VehicleConfig was = parse(demo_text()), is = parse(with_datum(demo_text(), request));
  EXPECT_NEAR(is.wheel[1].encoder.datum_rad, -107.125 * kDegree, 0.0051 * kDegree);  // two decimals
  EXPECT_NEAR(is.wheel[1].encoder.datum_sigma_rad, 0.41 * kDegree, 1e-12) << "not better than it was found";
  EXPECT_EQ(is.wheel[0].encoder.datum_rad, was.wheel[0].encoder.datum_rad);
  const auto refused = [&](Request wrong) {
    EXPECT_THROW((void)with_datum(demo_text(), wrong), ConfigError);
  };
  refused({.operation = Operation::kDatum, .channel = -1, .value = {0, 0.1}});
  refused({.operation = Operation::kDatum, .channel = 4, .value = {0, 0.1}});
  refused({.operation = Operation::kDatum, .channel = 0, .value = {7, 0.1}});
  refused({.operation = Operation::kDatum, .channel = 0, .value = {0, 0}});
  refused({.operation = Operation::kDatum, .channel = 0, .value = {0, 4}});
}

TEST(VehicleEdit, AZeroIsTheReadingOfItsNode) {
  StandstillReadings::Reading reading;
  for (std::size_t k = 0; k < reading.mean_counts.size(); ++k)
    reading.mean_counts[k] = 100.25 * static_cast<double>(k + 1);
  const VehicleConfig vehicle = parse(with_zero(demo_text(), {{2, reading}}));
  for (std::size_t k = 0; k < vehicle.node[1].channel.size(); ++k) {
    EXPECT_NEAR(vehicle.node[1].channel[k].offset_counts, reading.mean_counts[k], 0.051) << k;  // one decimal
    EXPECT_EQ(vehicle.node[0].channel[k].offset_counts, 0);
  }
}

}  // namespace
}  // namespace roadbalance
