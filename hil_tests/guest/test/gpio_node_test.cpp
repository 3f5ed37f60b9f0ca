#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdio>

#include "hil_tests/guest/can_player.hpp"
#include "hil_tests/guest/device_measurement.hpp"
#include "hil_tests/guest/gpio_rig.hpp"
#include "hil_tests/guest/played_rings.hpp"
#include "hil_tests/guest/recorded_parts.hpp"
#include "hil_tests/guest/running_module.hpp"

namespace roadbalance {
namespace {

using test::Program;
using test::PulseChip;

constexpr double kPlayed_s = 60.0;  // longer than any measurement here: what is not needed is forgotten

/// rb-node whose wheels' rings are on GPIO and whose accelerometer module is on CAN, recorded.
class GpioNodeTest : public test::DeviceMeasurement {
 protected:
  void SetUp() override { wire(test::RunningModule::wiring("vx0") + test::PlayedRings::kWiring, 1000); }
  void turn_wheels() { wheels.turn(VehicleConfig::read_file(vehicle_file), kPlayed_s); }
  Program node_on_gpio() const { return device_node({"can:vx0", chip}); }

  const std::string chip = "gpio:" + PulseChip::name();
  const test::VirtualCan cable{"vx0", "vx1"};
  test::PlayedRings wheels;
};

struct Interval {
  std::int64_t from_ns, to_ns;  ///< CLOCK_MONOTONIC
};

/// Blocks that lie in the interval: all of them, and those with a flag.
std::pair<int, int> blocks_in(const std::vector<ScanBlock>& blocks, const test::JudgedRing& ring,
                              Interval interval) {
  int all = 0, flagged = 0;
  for (const ScanBlock& block : blocks) {
    const auto first_ns = ring.monotonic_ns(node_time_from_ns(block.row_time_ns(0)));
    const auto last_ns = ring.monotonic_ns(node_time_from_ns(block.row_time_ns(block.header.scans - 1)));
    if (first_ns < interval.from_ns || last_ns > interval.to_ns) continue;
    ++all;
    flagged += test::is_flagged(block, ring.line);
  }
  return {all, flagged};
}

TEST_F(GpioNodeTest, DeclaresEdgesThatWentByWhileItWasHeldAndWhileTheChipWasGone) {
  test::RunningModule module("vx1");
  Program running = recorder();
  Program front = node_on_gpio();
  ASSERT_TRUE(more_are_durable(kFront, 20));
  turn_wheels();
  bus.listen(3.0);
  EXPECT_EQ(count_of(DeviceCounter::kEdgesLost), 0);
  const Interval well{PulseChip::now_ns() - 1'000'000'000, PulseChip::now_ns() - 200'000'000};

  Interval held{PulseChip::now_ns(), 0};
  front.signal(SIGSTOP);
  bus.listen(0.3);
  held.to_ns = PulseChip::now_ns();
  front.signal(SIGCONT);
  EXPECT_TRUE(bus.wait([&] { return count_of(DeviceCounter::kEdgesLost) >= 2; })) << "each line";
  bus.listen(1.5);

  Interval gone{PulseChip::now_ns(), 0};
  PulseChip::unplug();
  EXPECT_TRUE(counted(DeviceCounter::kGone, 1));
  bus.listen(0.3);
  gone.to_ns = PulseChip::now_ns();
  PulseChip::plug();
  EXPECT_TRUE(counted(DeviceCounter::kReturned, 1));
  bus.listen(2.0);
  const Interval after{PulseChip::now_ns() - 800'000'000, PulseChip::now_ns() - 200'000'000};
  for (const std::int64_t faults : bus.heartbeat(kFront).encoder_faults) EXPECT_GE(faults, 2);
  end_well(running, {&front});

  expect_verified(record, 1);  // no scan is missing
  const std::vector<ScanBlock> blocks = test::recorded_blocks(record);
  const std::vector<Edge> edges = test::recorded_events(record, kFront).edges;
  for (const test::JudgedRing& ring : wheels.all()) {
    const auto lost = std::ranges::count_if(
        edges, [&](const Edge& edge) { return edge.kind == EdgeKind::kLost && edge.line == ring.line; });
    EXPECT_GE(lost, 3) << "held, gone and back";
    const test::TurnVerdict turns = judge_turns(edges, ring);
    const test::AngleVerdict angles = judge_angles(blocks, ring, [](std::int64_t) { return 0.0; });
    std::printf("line %d: %s; %s\n", ring.line, turns.text().c_str(), angles.text().c_str());
    EXPECT_EQ(turns.silent, 0);
    EXPECT_GE(turns.declared, 2);
    EXPECT_GE(turns.whole, 30);
    EXPECT_EQ(angles.silent_wrong, 0);
    EXPECT_GE(angles.right, 3000);
    const std::pair<const char*, Interval> good[] = {{"before it was held", well}, {"back again", after}};
    for (const auto& [when, interval] : good) {
      const auto [all, flagged] = blocks_in(blocks, ring, interval);
      EXPECT_GE(all, 20) << when;
      EXPECT_EQ(flagged, 0) << when << " doubted for no reason";
    }
    // The kernel keeps 16 edges; this wheel makes a thousand a second.
    for (const Interval& interval : {held, gone}) {
      const auto [all, flagged] = blocks_in(blocks, ring, {interval.from_ns + 30'000'000, interval.to_ns});
      EXPECT_GE(all, 10);
      EXPECT_EQ(flagged, all) << "an angle without edges";
    }
  }

  expect_said(chip, {"encoder edges are missing (", "was unplugged or went down (1 time by now)",
                     "is there again (1 time by now)"});
}

TEST_F(GpioNodeTest, SaysTurnsOfWhichTheKernelTookTwoEdgesAsOne) {
  test::RunningModule module("vx1");
  Program running = recorder();
  Program front = node_on_gpio();
  ASSERT_TRUE(more_are_durable(kFront, 20));
  turn_wheels();
  bus.listen(2.0);
  EXPECT_EQ(count_of(DeviceCounter::kFaultyTurns), 0);
  // The kernel's interrupt thread does not run for four milliseconds, in which both wheels give edges.
  const std::int64_t from_ns = PulseChip::now_ns() + 50'000'000;
  test::hog_processor(90, from_ns, from_ns + 4'000'000).join();
  const auto both_are_counted = [&] {
    const auto& faults = bus.heartbeat(kFront).encoder_faults;
    return faults[0] > 0 && faults[1] > 0;
  };
  EXPECT_TRUE(bus.wait(both_are_counted));
  EXPECT_EQ(count_of(DeviceCounter::kEdgesLost), 0) << "the kernel gives no sign";
  bus.listen(1.0);
  end_well(running, {&front});

  expect_verified(record, 1);
  const std::vector<ScanBlock> blocks = test::recorded_blocks(record);
  const std::vector<Edge> edges = test::recorded_events(record, kFront).edges;
  for (const test::JudgedRing& ring : wheels.all()) {
    const test::TurnVerdict turns = judge_turns(edges, ring);
    const test::AngleVerdict angles = judge_angles(blocks, ring, [](std::int64_t) { return 0.0; });
    std::printf("line %d: %s; %s\n", ring.line, turns.text().c_str(), angles.text().c_str());
    EXPECT_GE(turns.declared, 1);
    EXPECT_EQ(turns.silent, 0);
    EXPECT_EQ(angles.silent_wrong, 0);
    expect_said("encoder of line " + std::to_string(ring.line), {sentence(DeviceCounter::kFaultyTurns)});
  }
}

TEST_F(GpioNodeTest, DoesNotBeginOnAChipThatIsNotThere) {
  Program front = device_node({"can:vx0", "gpio:gpiochip77"});
  EXPECT_EQ(front.exit_code(bus.kPatience_s), 4) << "systemd tries again";
  EXPECT_NE(said().find("front end gpio:gpiochip77: GPIO chip gpiochip77: No such file or directory"),
            std::string::npos)
      << said();
}

}  // namespace
}  // namespace roadbalance
