#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "common/config/text_file.hpp"
#include "common/frontend/device_report.hpp"
#include "common/test/source.hpp"
#include "hil_tests/measurement.hpp"
#include "hil_tests/players/usb_board/test/board_watch.hpp"
#include "hil_tests/players/usb_board/test/turning_wheels.hpp"

namespace roadbalance {
namespace {

using test::Program;
using test::UsbBoards;

constexpr double kRateHz = 2000.0;
constexpr double kPacket_s = 5e-3;  ///< a board's packet holds the scans of so long

/// rb-node with the front-end board, recorded; both wheels' encoders are at the board.
class UsbNodeTest : public test::Measurement {
 protected:
  void SetUp() override { std::ofstream(vehicle) << test::read_source("sim/demo/vehicle.toml"); }

  static test::Bench bench() {
    test::Bench bench = test::numbered_bench("BENCH1", 30.0);
    bench.next_change = test::TurningWheels(
        {{.line = 0, .teeth = 96, .turns_hz = 10.0}, {.line = 1, .teeth = 96, .turns_hz = 11.3}});
    return bench;
  }
  Program node_on_usb() const {
    const std::string command =
        "exec \"$0\" --vehicle \"$1\" --node front --front-end usb:1209:0001 --url \"$2\" 2>\"$3\"";
    return {"bash", {"-c", command, test::binaries() / "rb-node", vehicle, url, errors}};
  }
  bool counted(DeviceCounter counter, std::int64_t times) {
    return bus.wait(
        [&] { return bus.heartbeat(kFront).device_counts[static_cast<std::size_t>(counter)] == times; });
  }
  void plug() {
    boards.plug();
    const VehicleConfig car = test::board_vehicle();
    test::open_when_enumerated({"1209:0001", car, car.node[0]});
  }
  MachineTime run_began() {
    MachineTime time{};
    boards.with(0, [&](test::BenchBoard& board) { time = board.conversion_time(0); });
    return time;
  }
  const std::string vehicle = work.path() / "vehicle.toml";
  const std::string errors = work.path() / "errors";
  UsbBoards boards{{bench()}};
};

TEST_F(UsbNodeTest, DeclaresWhatTheCableSpoiledAndWhatWentByWhileItWasPulled) {
  plug();
  Program running = recorder();
  Program front = node_on_usb();
  ASSERT_TRUE(more_are_durable(kFront, 20));
  boards.faults().stall = 1;
  ASSERT_TRUE(counted(DeviceCounter::kStalls, 1));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  boards.faults().cut = 1;
  ASSERT_TRUE(counted(DeviceCounter::kShortPackets, 1));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  boards.faults().corrupt = 1;
  ASSERT_TRUE(counted(DeviceCounter::kPacketsRefused, 1));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  const MachineTime first = run_began();
  boards.unplug();
  const MachineTime unplugged = MachineClock::now();
  ASSERT_TRUE(counted(DeviceCounter::kGone, 1));
  boards.plug();
  ASSERT_TRUE(counted(DeviceCounter::kReturned, 1));
  const MachineTime second = run_began();
  ASSERT_TRUE(more_are_durable(kFront, 20));
  for (const std::int64_t faults : bus.heartbeat(kFront).encoder_faults) EXPECT_GE(faults, 3);
  ASSERT_TRUE(counted(DeviceCounter::kPacketsMissing, 2)) << "those that were cut and spoiled";
  end_well(running, {&front});

  const Verification verified = verify_record(record);
  EXPECT_EQ(verified.verdict, Verdict::kIncomplete) << verdict_text(verified);
  ASSERT_EQ(verified.epoch.size(), 1U);
  const VerifiedEpoch& epoch = verified.epoch[0];
  EXPECT_FALSE(epoch.is_damaged());
  ASSERT_EQ(epoch.gaps.size(), 3U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(epoch.gaps[k].cause, GapCause::kDeviceOverrun);
    EXPECT_NEAR(static_cast<double>(epoch.gaps[k].scans), kPacket_s * kRateHz, 2.0) << "one packet";
  }
  EXPECT_EQ(epoch.gaps[2].cause, GapCause::kDeviceGone);
  // From the last packet before the cable was pulled to the first scan of the new run.
  const double absent_s = 1e-9 * static_cast<double>((second - unplugged).count());
  EXPECT_NEAR(static_cast<double>(epoch.gaps[2].scans), absent_s * kRateHz, 2.0 * kPacket_s * kRateHz);
  EXPECT_GT(second, first);

  const std::string said = read_text_file(errors);
  for (const char* sentence :
       {"the board halted its transfers (1 time by now)", "packets ended before their time (1 time by now)",
        "packets were refused: wrong mark, length or CRC (1 time by now)",
        "packets are missing (2 times by now)", "was unplugged or went down (1 time by now)",
        "is there again (1 time by now)"}) {
    EXPECT_NE(said.find(std::string("usb:1209:0001: ") + sentence), std::string::npos)
        << sentence << " is not in: " << said;
    const bool is_noted = std::ranges::any_of(verified.notes, [&](const std::string& note) {
      return note.find("devices of node 1") != std::string::npos && note.find(sentence) != std::string::npos;
    });
    EXPECT_TRUE(is_noted) << sentence << " is no note of the record";
  }
}

}  // namespace
}  // namespace roadbalance
