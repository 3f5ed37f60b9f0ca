#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "hil_tests/guest/device_measurement.hpp"
#include "hil_tests/guest/recorded_parts.hpp"
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

/// rb-node with two boards, half of its channels at each, whose inputs encode their time of conversion.
class TwoBoardsNodeTest : public test::DeviceMeasurement {
 protected:
  /// 0.4 s are more than the node keeps of one board; a silent one is started again after 1 s.
  static constexpr int kRate_hz = 10'000;
  static constexpr const char* kBoards = "usb:1209:0001:MASTER+SECOND";
  static constexpr const char* kMaster = "usb:1209:0001:MASTER";
  static constexpr const char* kSecond = "usb:1209:0001:SECOND";

  void SetUp() override { wire({}, kRate_hz); }

  test::Bench second() {
    test::Bench bench = test::timed_bench("SECOND", -60.0);
    bench.bounces = [this](std::int64_t) -> std::optional<double> {
      if (early > 0 && early-- > 0) return 0.1;
      if (late > 0 && late-- > 0) return 0.6;
      return std::nullopt;
    };
    return bench;
  }
  std::int64_t rows_apart() const {
    std::int64_t apart = 0, rows = 0;
    for (const ScanBlock& block : test::recorded_blocks(record))
      for (std::size_t row = 0; row < static_cast<std::size_t>(block.header.scans); ++row, ++rows)
        for (std::size_t c = 0; c < 6; ++c) apart += block.counts[row][c] != block.counts[row][6 + c];
    EXPECT_GT(rows, kRate_hz);
    return apart;
  }

  /// Edges too many of SYNC: so soon that the board drops the conversion, and so late that it drops the true
  /// one behind it.
  std::atomic<int> early{0}, late{0};
  UsbBoards boards{{test::timed_bench("MASTER", 60.0), second()}};
};

TEST_F(TwoBoardsNodeTest, SaysAndDeclaresWhatComesBetweenThem) {
  boards.plug(1);
  test::plug(boards, kBoards);
  Program running = recorder();
  Program front = device_node({kBoards});
  ASSERT_TRUE(more_are_durable(kFront, 20));
  early = 3;
  ASSERT_TRUE(counted(DeviceCounter::kGlitches, 3));
  boards.faults().deaf = 1000;
  ASSERT_TRUE(counted(DeviceCounter::kClockUnanswered, 1));
  boards.faults().deaf = 0;
  ASSERT_TRUE(more_are_durable(kFront, 20));

  boards.faults(1).held = true;
  bus.listen(0.5);
  boards.faults(1).held = false;
  ASSERT_TRUE(bus.wait([&] { return count_of(DeviceCounter::kBoardOverrun) > 0; }));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  bus.listen(1.0);  // all is counted by then, and sent: twice a second
  const std::int64_t overrun = count_of(DeviceCounter::kBoardOverrun);
  const std::int64_t partner_late = count_of(DeviceCounter::kPartnerLate);
  EXPECT_GT(partner_late, 0);

  const MachineTime slipped = MachineClock::now();
  late = 1;
  ASSERT_TRUE(counted(DeviceCounter::kOutOfStep, 1));
  ASSERT_TRUE(more_are_durable(kFront, 20));
  MachineTime again{};
  boards.with(0, [&](test::BenchBoard& board) { again = board.conversion_time(0); });
  EXPECT_EQ(count_of(DeviceCounter::kGone), 0);
  end_well(running, {&front});

  EXPECT_EQ(rows_apart(), 0);
  const std::vector<VerifiedGap> found = gaps();
  ASSERT_GE(found.size(), 3U);
  // As the second board's scans came at last, more of the first's went between them.
  std::int64_t went = 0;
  for (std::size_t k = 0; k + 2 < found.size(); ++k) {
    EXPECT_EQ(found[k].cause, GapCause::kDeviceOverrun);
    went += found[k].scans;
  }
  EXPECT_EQ(went, partner_late);
  const VerifiedGap &full = found[found.size() - 2], &absent = found.back();
  EXPECT_EQ(full.cause, GapCause::kDeviceOverrun);
  EXPECT_EQ(full.scans, overrun) << "its ring had no room";
  EXPECT_EQ(absent.cause, GapCause::kDeviceGone);
  const double absent_s = 1e-9 * static_cast<double>((again - slipped).count());
  EXPECT_NEAR(static_cast<double>(absent.scans), absent_s * kRate_hz, 2.0 * kPacket_s * kRate_hz);

  expect_said(kMaster, {sentence(DeviceCounter::kClockUnanswered, 1)});
  expect_said(kSecond,
              {sentence(DeviceCounter::kGlitches, 3), sentence(DeviceCounter::kPartnerLate, partner_late),
               sentence(DeviceCounter::kBoardOverrun, overrun), sentence(DeviceCounter::kOutOfStep, 1)});
}

}  // namespace
}  // namespace roadbalance
