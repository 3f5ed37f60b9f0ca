#include "tools/views/bus_view.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "common/bus/channel_faults.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/process_port.hpp"
#include "embedded/demo_vehicle.hpp"
#include "tools/demonstration/demo_start.hpp"
#include "tools/views/alarm_lines.hpp"
#include "tools/views/watch_json.hpp"
#include "tools/views/watch_lines.hpp"

namespace roadbalance {
namespace {

class BusViewTest : public testing::Test {
 protected:
  /// True if the view took it for a change of state.  It comes to itself over loopback.
  bool hear(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
    EXPECT_TRUE(bus_.publish(channel, bytes));
    view_.handle(std::chrono::seconds(5));
    return view_.state_changed();
  }
  bool said(const std::string& part) {
    for (const auto& line : watch_lines(view_))
      if (line.find(part) != std::string::npos) return true;
    return false;
  }

  const std::string url_ = bus_url_on_port(process_port());
  BusView view_{url_};
  Bus bus_{url_};
};

TEST_F(BusViewTest, ShowsNodesWithTheirClocks) {
  EXPECT_FALSE(view_.heard_anything());
  Heartbeat beat;
  beat.node = 2;
  beat.epoch = 9;
  EXPECT_TRUE(hear(heartbeat_channel(2), encode(beat)));
  beat.scans_sampled = 40;
  EXPECT_FALSE(hear(heartbeat_channel(2), encode(beat))) << "a counter that goes on is no news";
  EXPECT_TRUE(said("node 2: 40 samples"));
  beat.owner = 6;
  EXPECT_TRUE(hear(heartbeat_channel(2), encode(beat)));

  ClockFit fit;
  fit.node = 2;
  fit.epoch = 9;
  fit.state = ClockState::kLocked;
  fit.uncertainty_s = 21e-6;
  EXPECT_TRUE(hear(clock_fit_channel(2), encode(fit)));
  EXPECT_TRUE(said("node 2 clock locked to 21.0 us"));
  fit.drift = 1e-6;
  EXPECT_FALSE(hear(clock_fit_channel(2), encode(fit)));
  fit.breaks = 1;
  EXPECT_TRUE(hear(clock_fit_channel(2), encode(fit)));

  const auto json = watch_json(view_);
  EXPECT_TRUE(json.at("wheels").is_null());
  EXPECT_EQ(json.at("nodes").at(0).at("owner"), 6);
  EXPECT_EQ(json.at("clocks").at(0).at("breaks"), 1);
}

TEST_F(BusViewTest, ShowsWhatTheNewestEstimateRestsOn) {
  for (const Remark& remark : remarks_of(1, {"the scale rests on masses", "static only"}))
    hear(kRemarkChannel, encode(remark));
  EXPECT_TRUE(said("  * static only"));
  EXPECT_EQ(watch_json(view_).at("remarks").size(), 2U);
  // One sentence of the next estimate is left.
  hear(kRemarkChannel, encode(remarks_of(2, {"the scale rests on masses"})[0]));
  EXPECT_TRUE(said("  * the scale rests on masses"));
  EXPECT_FALSE(said("static only"));
  hear(kRemarkChannel, encode(remarks_of(3, {})[0]));
  EXPECT_FALSE(said("  * "));
}

TEST_F(BusViewTest, ShowsWhatWeightsHaveDone) {
  hear(kBalanceChannel, encode(Balance{.wheel = 1}));
  WeightCheck wheel{.wheel = 1,
                    .state = WeightCheckState::kKnown,
                    .verdict = WeightCheckVerdict::kGood,
                    .placement = WeightPlacement::kAsWanted,
                    .reduction = 0.94,
                    .sigma_reduction = 0.021,
                    .text = "drive1"};
  wheel.before_g << 35.0, 0.0;
  wheel.after_g << 0.0, 2.1;
  hear(kWeightCheckChannel, encode(wheel));
  EXPECT_TRUE(said("before (drive1) 35.0 g, now 2.1 g: 94 % less, ± 3 %; good"));
  const auto json = watch_json(view_).at("verification").at(0);
  EXPECT_EQ(json.at("wheel"), "front_right");
  EXPECT_EQ(json.at("verdict"), "good");
  EXPECT_EQ(json.at("placement"), "as_wanted");
  wheel.state = WeightCheckState::kNotComparable;
  wheel.text = "another encoder";
  hear(kWeightCheckChannel, encode(wheel));
  EXPECT_TRUE(said("no comparison: another encoder"));
  EXPECT_TRUE(watch_json(view_).at("verification").at(0).at("after_g").is_null());
}

TEST_F(BusViewTest, ShowsWhatDevicesSuffer) {
  Heartbeat beat{.node = 2, .epoch = 9};
  EXPECT_TRUE(hear(heartbeat_channel(2), encode(beat)));
  EXPECT_FALSE(said("devices"));
  EXPECT_EQ(watch_json(view_).at("nodes").at(0).at("devices").size(), 0U);
  auto& errors = beat.device_counts[static_cast<std::size_t>(DeviceCounter::kBusErrors)];
  auto& gone = beat.device_counts[static_cast<std::size_t>(DeviceCounter::kGone)];
  errors = 5;
  EXPECT_TRUE(hear(heartbeat_channel(2), encode(beat)));
  EXPECT_TRUE(said("  ! devices: bus_errors 5"));
  errors = 7;
  EXPECT_FALSE(hear(heartbeat_channel(2), encode(beat))) << "a counter that goes on is no news";
  gone = 1;
  EXPECT_TRUE(hear(heartbeat_channel(2), encode(beat)));
  gone = 2;
  EXPECT_TRUE(hear(heartbeat_channel(2), encode(beat))) << "each time it goes is";
  EXPECT_TRUE(said("  ! devices: gone 2, bus_errors 7"));
  const auto devices = watch_json(view_).at("nodes").at(0).at("devices");
  EXPECT_EQ(devices.size(), 2U);
  EXPECT_EQ(devices.at("gone"), 2);
  EXPECT_EQ(devices.at("bus_errors"), 7);

  beat.encoder_faults = {0, 3};
  beat.unreferenced_blocks = 11;
  beat.device_counts[static_cast<std::size_t>(DeviceCounter::kFaultyTurns)] = 3;
  EXPECT_TRUE(hear(heartbeat_channel(2), encode(beat)));
  EXPECT_TRUE(said("  ! devices: gone 2, bus_errors 7, faulty_turns 3"));
  const auto node = watch_json(view_).at("nodes").at(0);
  EXPECT_EQ(node.at("faulty_turns"), (std::vector<std::int64_t>{0, 3}));
  EXPECT_EQ(node.at("blocks_without_angle"), 11);
}

TEST_F(BusViewTest, ShowsAPlanBesideTheBalanceThatItFollowsFrom) {
  Balance balance{.wheel = 1, .time_ns = 50, .state = Unknown::kNone, .unbalance_g = 20.0};
  Compensation compensation{.wheel = 1, .time_ns = 50, .advice = Advice::kSteps};
  compensation.plan.step = {{WeightAction::kAdd, {20.0, 0.0, 0.19}, {}}};
  hear(kIdentificationChannel, encode(Identification{}));
  hear(kCompensationChannel, encode(compensation));
  hear(kBalanceChannel, encode(balance));
  EXPECT_TRUE(said("  add 20 g at 0°"));
  EXPECT_EQ(watch_json(view_).at("compensation").at(1).at("advice"), "steps");
  balance.time_ns = 51;
  hear(kBalanceChannel, encode(balance));
  EXPECT_FALSE(said("add 20 g")) << "of another balance";
  EXPECT_TRUE(watch_json(view_).at("compensation").at(1).at("advice").is_null());
}

TEST_F(BusViewTest, ShowsRecordersAndWhatAlarmsThem) {
  RecorderStatus status;
  status.recorder = status.incarnation = 5;
  EXPECT_TRUE(hear(kRecorderChannel, encode(status)));
  status.bytes_recorded = 1000;
  EXPECT_FALSE(hear(kRecorderChannel, encode(status)));
  status.state = RecorderState::kDiskFailing;
  status.disk_failures = 1;
  EXPECT_TRUE(hear(kRecorderChannel, encode(status)));
  EXPECT_TRUE(said("THE DISK FAILS (1 times)"));
  EXPECT_EQ(watch_json(view_).at("recorders").at(0).at("state"), "disk_failing");
  status.recorder = status.incarnation = 6;
  EXPECT_TRUE(hear(kRecorderChannel, encode(status)));
  EXPECT_TRUE(said("more than one recorder"));
}

TEST_F(BusViewTest, ShowsWhatIsWrongWithItsLevelTheWorstFirst) {
  Heartbeat beat{.node = 2, .epoch = 1};
  hear(heartbeat_channel(2), encode(beat));
  EXPECT_TRUE(watch_json(view_).at("alarms").empty());
  Level level{.node = 2};
  set_dead(level, 3);
  hear(kLevelChannel, encode(level));
  beat.scans_missing = 35;
  EXPECT_TRUE(hear(heartbeat_channel(2), encode(beat)));
  EXPECT_TRUE(said("!!! ALARM node 2: samples lost (35 samples by now)"));
  EXPECT_TRUE(said(" !  WARNING node 2 channel 4: no signal"));
  const auto alarms = watch_json(view_).at("alarms");
  ASSERT_EQ(alarms.size(), 2u);
  EXPECT_EQ(alarms[0].at("level"), "ALARM");
  EXPECT_EQ(coloured(watch_lines(view_).front()), "\033[1;31m" + watch_lines(view_).front() + "\033[0m");
  EXPECT_EQ(coloured("node 2: 35 samples"), "node 2: 35 samples");
}

TEST_F(BusViewTest, KeepsNoMoreThanSoManyNodesTell) {
  constexpr auto kMost = static_cast<std::int32_t>(kMostNodes);
  for (std::int32_t node = 1; node <= kMost + 3; ++node) {
    hear(kLevelChannel, encode(Level{.node = node, .speed_m_s = 1.0}));
    for (std::int32_t channel = 0; channel < kChannels; ++channel)
      hear(kSpectrumChannel, encode(SpectrumPart{.node = node, .channel = channel}));
  }
  EXPECT_EQ(view_.levels().size(), kMostNodes);
  EXPECT_EQ(view_.highest_lines().size(), kMostNodes * kChannels);
  hear(kLevelChannel, encode(Level{.node = kMost, .speed_m_s = 10.0}));
  EXPECT_TRUE(said("node 64: 36.0 km/h")) << "those that are known go on";
}

TEST_F(BusViewTest, NoLevelEndsIt) {
  for (const double none : {std::numeric_limits<double>::quiet_NaN(), -1.0}) {
    Level level{.node = 2};
    level.rms.fill(none);
    hear(kLevelChannel, encode(level));
    EXPECT_FALSE(said("rms")) << none;
  }
}

TEST_F(BusViewTest, ShowsWhatTurnsWithAWheelWhereItShowsMost) {
  OrderReport near{.wheel = 1, .node = 2, .seconds = 60.0}, far{.wheel = 1, .node = 3, .seconds = 60.0};
  near.order[0][4] = {{0.0, 2.0}, 0.25, 0.1, 40};
  near.order[0][5] = {{9.0, 0.0}, std::numeric_limits<double>::quiet_NaN(), 0.1, 3};
  near.order[1][4] = {{0.5, 0.0}, 0.75, std::numeric_limits<double>::quiet_NaN(), 40};
  far.order[0][0] = {{0.3, 0.0}, 0.25, 0.1, 40};
  hear(kOrdersChannel, encode(near));
  hear(kOrdersChannel, encode(far));
  EXPECT_TRUE(
      said("front_right, order 1: node 2 channel 5  2.0000 ± 0.2500 m/s²  90.0 ± 5.7 deg  40 blocks"));
  EXPECT_TRUE(said("front_right, order 2: node 2 channel 5  0.5000 ± 0.7500 m/s²  40 blocks")) << "no phase";
  EXPECT_FALSE(said("channel 6  9.0")) << "three blocks have no confidence";
  EXPECT_FALSE(said("node 3 channel"));
  const auto orders = watch_json(view_).at("orders");
  ASSERT_EQ(orders.size(), 2U);
  EXPECT_EQ(orders[0].at("wheel"), "front_right");
  EXPECT_EQ(orders[0].at("orders").size(), 3U);
  EXPECT_EQ(orders[0].at("orders")[0].at("phase_deg"), 90.0);
  EXPECT_TRUE(orders[0].at("orders")[1].at("amplitude_95").is_null());
  EXPECT_TRUE(orders[0].at("orders")[2].at("phase_deg").is_null());
}

TEST_F(BusViewTest, TellsWhoOfADemoHasNotBegun) {
  const VehicleConfig car = VehicleConfig::parse(std::string(embedded::kDemoVehicle), "vehicle.toml");
  EXPECT_EQ(who_is_idle(car, view_), "node front is not heard");
  Heartbeat beat{.node = 1, .epoch = 9};
  hear(heartbeat_channel(1), encode(beat));
  EXPECT_EQ(who_is_idle(car, view_), "no recorder claims node front");
  beat.owner = 5;
  hear(heartbeat_channel(1), encode(beat));
  EXPECT_EQ(who_is_idle(car, view_), "node rear is not heard");
  hear(heartbeat_channel(2), encode(Heartbeat{.node = 2, .epoch = 9, .state = NodeState::kEnded}));
  EXPECT_EQ(who_is_idle(car, view_), "no analyser is heard");
  hear(kLevelChannel, encode(Level{.node = 1}));
  EXPECT_EQ(who_is_idle(car, view_), "");
}

}  // namespace
}  // namespace roadbalance
