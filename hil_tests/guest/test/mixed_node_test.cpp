#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <thread>

#include "common/config/text_file.hpp"
#include "common/frontend/device_report.hpp"
#include "common/test/source.hpp"
#include "hil_tests/guest/can_player.hpp"
#include "hil_tests/guest/played_rings.hpp"
#include "hil_tests/guest/recorded_parts.hpp"
#include "hil_tests/measurement.hpp"
#include "hil_tests/players/usb_board/test/board_watch.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using test::ip;
using test::Program;
using test::PulseChip;

constexpr std::uint32_t kWheels = 0xAA;
constexpr const char* kCar = R"(
BO_ 170 Wheels: 8 X
 SG_ Left : 7|16@0+ (0.01,0) [0|655.35] "km/h" X
)";
constexpr const char* kSignal =
    "[[node.can]]\ninterface = \"vcan6\"\nrole = \"vehicle\"\ndbc = \"car.dbc\"\n"
    "[[node.can.signal]]\nname = \"speed\"\nmessage = \"Wheels\"\nsignal = \"Left\"\n"
    "quantity = \"vehicle_speed\"\n";
constexpr double kRateHz = 5000.0;  // the board's ring holds 0.4 s of it, and it counts as silent after 1 s

/// The frame of a counter: 0.01 km/h is one.
CanFrame numbered(std::uint16_t number) {
  CanFrame frame{.id = kWheels, .size = 8};
  frame.data[0] = static_cast<std::uint8_t>(number >> 8);
  frame.data[1] = static_cast<std::uint8_t>(number);
  return frame;
}

/// rb-node with accelerations by USB, its wheels' rings by GPIO and a signal by CAN, recorded.
class MixedNodeTest : public test::Measurement {
 protected:
  void SetUp() override {
    std::string text = test::read_source("sim/demo/vehicle.toml");
    for (std::size_t at; (at = text.find("rate_hz = 2000")) != std::string::npos;)
      text.replace(at, 14, "rate_hz = 5000");
    text.insert(text.find("[[node.channel]]"), kSignal + std::string(test::PlayedRings::kWiring));
    std::ofstream(vehicle_file) << text;
    std::ofstream(work.path() / "car.dbc") << kCar;
    chip_uri = "gpio:" + PulseChip::name();
    boards.plug();
    const VehicleConfig car = test::board_vehicle();
    test::open_when_enumerated({"1209:0001", car, car.node[0]});
  }
  Program mixed_node() const {
    const std::string command =
        "exec \"$0\" --vehicle \"$1\" --node front --front-end usb:1209:0001 --front-end \"$4\" "
        "--front-end can:vcan6 --url \"$2\" 2>\"$3\"";
    return {"bash", {"-c", command, test::binaries() / "rb-node", vehicle_file, url, errors, chip_uri}};
  }
  std::int64_t count_of(DeviceCounter counter) const {
    return bus.heartbeat(kFront).device_counts[static_cast<std::size_t>(counter)];
  }
  bool counted(DeviceCounter counter, std::int64_t times) {
    return bus.wait([&] { return count_of(counter) == times; });
  }
  /// The node prints it and the record keeps it.
  void expect_said(const std::string& sentence, const std::vector<std::string>& notes) const {
    const std::string said = read_text_file(errors);
    EXPECT_NE(said.find("usb:1209:0001: " + sentence), std::string::npos)
        << sentence << " is not in: " << said;
    EXPECT_TRUE(std::ranges::any_of(notes,
                                    [&](const std::string& note) {
                                      return note.find("devices of node 1") != std::string::npos &&
                                             note.find(sentence) != std::string::npos;
                                    }))
        << sentence << " is no note of the record";
  }

  /// Not an edge was lost, and every angle that is given is right.
  void expect_whole_rings(const std::vector<Edge>& edges, const std::vector<VerifiedGap>& gaps) const {
    const std::vector<ScanBlock> blocks = test::recorded_blocks(record);
    ASSERT_GT(blocks.size(), 100U);
    const auto ms = [](double scans) { return std::to_string(std::lround(1e3 * scans / kRateHz)) + " ms"; };
    std::string absences;
    for (const VerifiedGap& gap : gaps)
      absences +=
          ", gap " + ms(static_cast<double>(gap.first_scan)) + " + " + ms(static_cast<double>(gap.scans));
    for (const Edge& edge : edges)
      EXPECT_NE(edge.kind, EdgeKind::kLost)
          << "at " << ms(1e-9 * kRateHz * static_cast<double>(to_ns(edge.time) - blocks[0].header.time_ns))
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

  const std::string vehicle_file = work.path() / "vehicle.toml";
  const std::string errors = work.path() / "errors";
  std::string chip_uri;
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
  wheels.turn(VehicleConfig::read_file(vehicle_file), 25.0);
  test::CanPlayer car("vcan6");
  const std::jthread driving([&car](const std::stop_token& stop) {
    for (std::uint16_t number = 0; !stop.stop_requested(); ++number) {
      car.send(numbered(number));
      std::this_thread::sleep_for(5ms);
    }
  });
  Program running = recorder();
  Program front = mixed_node();
  ASSERT_TRUE(more_are_durable(kFront, 20));
  bus.listen(1.0);
  // Its firmware has forgotten its run: it says nothing any more, and is started again.
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

  const Verification verified = verify_record(record);
  EXPECT_EQ(verified.verdict, Verdict::kIncomplete) << verdict_text(verified);
  ASSERT_EQ(verified.epoch.size(), 1U);
  const auto& gaps = verified.epoch[0].gaps;
  ASSERT_EQ(gaps.size(), 2U);
  for (const VerifiedGap& gap : gaps) EXPECT_EQ(gap.cause, GapCause::kDeviceGone);
  EXPECT_GT(static_cast<double>(gaps[1].scans), 0.5 * kRateHz);
  for (const char* sentence :
       {"was unplugged or went down (2 times by now)", "is there again (2 times by now)"})
    expect_said(sentence, verified.notes);

  const RecordedPiece events = test::recorded_events(record, kFront);
  expect_every_number(events.signals, 600);
  expect_whole_rings(events.edges, gaps);
}

// Without wheels: a board that catches up takes this machine's one processor from the GPIO, as no real one
// does.
TEST_F(MixedNodeTest, WhatTheBoardHadNoRoomForIsSaidAndDeclared) {
  Program running = recorder();
  Program front = mixed_node();
  ASSERT_TRUE(more_are_durable(kFront, 20));
  // Nobody serves the endpoint for longer than the board's ring holds.
  boards.with(0, [](test::BenchBoard&) { std::this_thread::sleep_for(700ms); });
  ASSERT_TRUE(bus.wait([&] { return count_of(DeviceCounter::kBoardOverrun) > 0; }));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  const std::int64_t overrun = count_of(DeviceCounter::kBoardOverrun);
  end_well(running, {&front});
  const Verification verified = verify_record(record);
  ASSERT_EQ(verified.epoch.size(), 1U);
  ASSERT_EQ(verified.epoch[0].gaps.size(), 1U);
  EXPECT_EQ(verified.epoch[0].gaps[0].cause, GapCause::kDeviceOverrun);
  EXPECT_EQ(verified.epoch[0].gaps[0].scans, overrun);
  expect_said("the board lost scans before it could send them (" + std::to_string(overrun) + " times by now)",
              verified.notes);
}

/// rb-node on a board whose firmware is older than it.
class OlderFirmwareTest : public test::Measurement {};

TEST_F(OlderFirmwareTest, IsRefusedByTheNodeNamingBothVersionsAndWhatIsNeeded) {
  test::Bench bench = test::numbered_bench("PAST");
  bench.major = 0;
  test::UsbBoards boards{{bench}};
  boards.plug();
  const std::string errors = work.path() / "errors";
  const std::string command =
      "exec \"$0\" --vehicle \"$1\" --node front --front-end usb:1209:0001:PAST --url \"$2\" 2>\"$3\"";
  std::string said = "is plugged in";
  for (int attempt = 0; attempt < 50 && said.find("is plugged in") != std::string::npos; ++attempt) {
    Program front("bash", {"-c", command, test::binaries() / "rb-node",
                           test::source_path("sim/demo/vehicle.toml"), url, errors});
    EXPECT_GT(front.exit_code(bus.kPatience_s).value_or(0), 0);
    said = read_text_file(errors);
    std::this_thread::sleep_for(100ms);
  }
  EXPECT_NE(said.find("rb-node: usb:1209:0001:PAST: the board speaks protocol 0.0, this node 1.0; newer "
                      "firmware of the board is needed"),
            std::string::npos)
      << said;
}

}  // namespace
}  // namespace roadbalance
