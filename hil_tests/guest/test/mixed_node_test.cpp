#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <fstream>
#include <thread>

#include "hil_tests/guest/can_player.hpp"
#include "hil_tests/guest/device_measurement.hpp"
#include "hil_tests/guest/played_rings.hpp"
#include "hil_tests/guest/recorded_parts.hpp"
#include "hil_tests/guest/speed_message.hpp"
#include "hil_tests/players/usb_board/test/board_watch.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using test::Program;
using test::PulseChip;
using test::SpeedMessage;

constexpr const char* kBoard = "usb:1209:0001";
constexpr int kRate_hz = 5000;  // the board's ring holds 0.4 s of it, and it counts as silent after 1 s

/// rb-node with accelerations by USB, its wheels' rings by GPIO and a signal by CAN, recorded.
class MixedNodeTest : public test::DeviceMeasurement {
 protected:
  void SetUp() override {
    wire(std::string("[[node.can]]\ninterface = \"vcan6\"\nrole = \"vehicle\"\n") + SpeedMessage::kSignal +
             test::PlayedRings::kWiring,
         kRate_hz);
    std::ofstream(work.path() / "car.dbc") << SpeedMessage::kDbc;
    test::plug(boards, kBoard);
  }
  Program mixed_node() const { return device_node({kBoard, "gpio:" + PulseChip::name(), "can:vcan6"}); }

  /// Not an edge was lost, and every angle that is given is right.
  void expect_whole_rings(const std::vector<Edge>& edges, const std::vector<VerifiedGap>& gaps) const {
    const std::vector<ScanBlock> blocks = test::recorded_blocks(record);
    ASSERT_GT(blocks.size(), 100U);
    const auto ms = [](double scans) { return std::to_string(std::lround(1e3 * scans / kRate_hz)) + " ms"; };
    std::string absences;
    for (const VerifiedGap& gap : gaps)
      absences +=
          ", gap " + ms(static_cast<double>(gap.first_scan)) + " + " + ms(static_cast<double>(gap.scans));
    for (const Edge& edge : edges)
      EXPECT_NE(edge.kind, EdgeKind::kLost)
          << "at " << ms(1e-9 * kRate_hz * static_cast<double>(to_ns(edge.time) - blocks[0].header.time_ns))
          << absences;
    for (const test::JudgedRing& ring : wheels.all()) {
      const test::TurnVerdict turns = judge_turns(edges, ring);
      const test::AngleVerdict angles = judge_angles(blocks, ring, [](std::int64_t) { return 0.0; });
      std::printf("line %d: %s; %s\n", ring.line, turns.text().c_str(), angles.text().c_str());
      EXPECT_GE(turns.whole, 30);
      EXPECT_EQ(turns.declared, 0);
      EXPECT_EQ(turns.silent, 0);
      EXPECT_EQ(angles.silent_wrong, 0);
      EXPECT_GE(angles.right, 10'000);
      EXPECT_FALSE(test::is_flagged(blocks[blocks.size() - 10], ring.line)) << "the angle is known again";
    }
  }

  const test::VirtualCan bus_of_the_car{"vcan6"};
  test::PlayedRings wheels;
  test::UsbBoards boards{{test::numbered_bench("BENCH1", 30.0)}};
};

/// Every number from the first that was recorded to the last, once.
void expect_every_number(const std::vector<SignalSample>& signals, int least) {
  ASSERT_GT(static_cast<int>(signals.size()), least);
  const auto number = [](const SignalSample& sample) { return std::llround(sample.value * 3.6 / 0.01); };
  for (std::size_t k = 1; k < signals.size(); ++k)
    ASSERT_EQ(number(signals[k]), number(signals[k - 1]) + 1) << "sample " << k;
}

TEST_F(MixedNodeTest, ABoardThatForgetsItsRunAndIsPulledCostsItsOwnSamplesAndNoMore) {
  test::CanPlayer car("vcan6");
  const std::jthread driving([&car](const std::stop_token& stop) {
    for (std::uint16_t number = 0; !stop.stop_requested(); ++number) {
      car.send(SpeedMessage::frame(number));
      std::this_thread::sleep_for(5ms);
    }
  });
  Program running = recorder();
  Program front = mixed_node();
  ASSERT_TRUE(more_are_durable(kFront, 20));
  wheels.turn(VehicleConfig::read_file(vehicle_file), 60.0);  // longer than this measurement
  bus.listen(1.5);
  // Its firmware has forgotten its run: it sends nothing any more, and is started again.
  boards.with(0, [](test::BenchBoard& board) { board.reset(); });
  ASSERT_TRUE(counted(DeviceCounter::kReturned, 1));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  boards.unplug();
  ASSERT_TRUE(counted(DeviceCounter::kGone, 2));
  bus.listen(0.5);
  boards.plug();
  ASSERT_TRUE(counted(DeviceCounter::kReturned, 2));
  bus.listen(1.5);
  EXPECT_EQ(count_of(DeviceCounter::kEdgesLost), 0);
  EXPECT_EQ(count_of(DeviceCounter::kLateEdges), 0);
  EXPECT_EQ(count_of(DeviceCounter::kReadersTooSlow), 0);
  for (const std::int64_t faults : bus.heartbeat(kFront).encoder_faults) EXPECT_EQ(faults, 0);
  end_well(running, {&front});

  const std::vector<VerifiedGap> absences = gaps();
  ASSERT_EQ(absences.size(), 2U);
  for (const VerifiedGap& gap : absences) EXPECT_EQ(gap.cause, GapCause::kDeviceGone);
  EXPECT_GT(static_cast<double>(absences[1].scans), 0.5 * kRate_hz);
  expect_said(kBoard, {"was unplugged or went down (2 times by now)", "is there again (2 times by now)"});

  const RecordedPiece events = test::recorded_events(record, kFront);
  expect_every_number(events.signals, 600);
  expect_whole_rings(events.edges, absences);
}

TEST_F(MixedNodeTest, SaysWhatIsWiredToItButNotAmongItsFrontEnds) {
  const Program front = device_node({kBoard});
  for (const char* sentence :
       {"[[node.line]] wires the encoder of line 0 to GPIO, but no gpio: is among its front ends",
        "[[node.line]] wires the encoder of line 1 to GPIO, but no gpio: is among its front ends",
        "[[node.can]] describes vcan6, but no can:vcan6 is among its front ends"})
    EXPECT_TRUE(bus.wait([&] { return said().find(sentence) != std::string::npos; })) << said();
}

// Without wheels: a board that catches up takes this machine's one processor from the GPIO, as no real one
// does.
TEST_F(MixedNodeTest, WhatTheBoardHadNoRoomForIsSaidAndDeclared) {
  Program running = recorder();
  Program front = mixed_node();
  ASSERT_TRUE(more_are_durable(kFront, 20));
  // The endpoint is not served for longer than the board's ring holds.
  boards.with(0, [](test::BenchBoard&) { std::this_thread::sleep_for(700ms); });
  ASSERT_TRUE(bus.wait([&] { return count_of(DeviceCounter::kBoardOverrun) > 0; }));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  const std::int64_t overrun = count_of(DeviceCounter::kBoardOverrun);
  end_well(running, {&front});
  const std::vector<VerifiedGap> found = gaps();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].cause, GapCause::kDeviceOverrun);
  EXPECT_EQ(found[0].scans, overrun);
  expect_said(kBoard, {sentence(DeviceCounter::kBoardOverrun, overrun)});
}

/// rb-node on a board whose firmware is older than it.
class OlderFirmwareTest : public test::DeviceMeasurement {};

TEST_F(OlderFirmwareTest, IsRefusedByTheNodeNamingBothVersionsAndWhatIsNeeded) {
  test::Bench bench = test::numbered_bench("PAST");
  bench.major = 0;
  test::UsbBoards boards{{bench}};
  boards.plug();
  wire({}, 2000);
  const std::string refused =
      "rb-node: usb:1209:0001:PAST: the board speaks protocol 0.0, this node 1.0; newer firmware of the "
      "board is "
      "needed";
  // The kernel enumerates for some time.
  for (int attempt = 0; attempt < 50 && (attempt == 0 || said().find(refused) == std::string::npos);
       ++attempt) {
    Program front = device_node({"usb:1209:0001:PAST"});
    EXPECT_GT(front.exit_code(bus.kPatience_s).value_or(0), 0);
    std::this_thread::sleep_for(100ms);
  }
  EXPECT_NE(said().find(refused), std::string::npos) << said();
}

}  // namespace
}  // namespace roadbalance
