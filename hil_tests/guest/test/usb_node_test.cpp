#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "hil_tests/guest/device_measurement.hpp"
#include "hil_tests/players/usb_board/test/board_watch.hpp"
#include "hil_tests/players/usb_board/test/turning_wheels.hpp"

namespace roadbalance {
namespace {

using test::Program;
using test::UsbBoards;

constexpr const char* kBoard = "usb:1209:0001";
constexpr int kRate_hz = 2000;
constexpr double kPacket_s = 5e-3;  ///< a board's packet holds the scans of so long

/// rb-node with the front-end board, recorded; both wheels' encoders are at the board.
class UsbNodeTest : public test::DeviceMeasurement {
 protected:
  void SetUp() override { wire({}, kRate_hz); }

  static test::Bench bench() {
    test::Bench bench = test::numbered_bench("BENCH1", 30.0);
    bench.next_change = test::TurningWheels(
        {{.line = 0, .teeth = 96, .turns_hz = 10.0}, {.line = 1, .teeth = 96, .turns_hz = 11.3}});
    return bench;
  }
  MachineTime run_began() {
    MachineTime time{};
    boards.with(0, [&](test::BenchBoard& board) { time = board.conversion_time(0); });
    return time;
  }
  UsbBoards boards{{bench()}};
};

TEST_F(UsbNodeTest, DeclaresWhatTheCableSpoiledAndWhatWentByWhileItWasPulled) {
  test::plug(boards, kBoard);
  Program running = recorder();
  Program front = device_node({kBoard});
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

  const std::vector<VerifiedGap> found = gaps();
  ASSERT_EQ(found.size(), 3U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(found[k].cause, GapCause::kDeviceOverrun);
    EXPECT_NEAR(static_cast<double>(found[k].scans), kPacket_s * kRate_hz, 2.0) << "one packet";
  }
  EXPECT_EQ(found[2].cause, GapCause::kDeviceGone);
  // From the last packet before the cable was pulled to the first scan of the new run.
  const double absent_s = 1e-9 * static_cast<double>((second - unplugged).count());
  EXPECT_NEAR(static_cast<double>(found[2].scans), absent_s * kRate_hz, 2.0 * kPacket_s * kRate_hz);
  EXPECT_GT(second, first);

  expect_said(kBoard, {"the board halted its transfers (1 time by now)",
                       "packets ended before their time (1 time by now)",
                       "packets were refused: wrong mark, length or CRC (1 time by now)",
                       "packets are missing (2 times by now)", "was unplugged or went down (1 time by now)",
                       "is there again (1 time by now)"});
}

}  // namespace
}  // namespace roadbalance
