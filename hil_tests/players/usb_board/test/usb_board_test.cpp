#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "hil_tests/players/usb_board/test/usb_board_fixture.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using test::kRateHz;

/// Bytes that this process has allocated and not given back.
std::size_t bytes_in_use() {
  const struct mallinfo2 heap = ::mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

std::size_t open_files() {
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

class UsbBoardTest : public test::UsbBoardFixture {
 protected:
  /// One thing goes wrong; what is missing is one declared gap, all other scans are right.
  void expect_one_gap(const std::function<void()>& go_wrong, GapCause cause) {
    boards.plug();
    open();
    ASSERT_TRUE(watch->more_scans(1000));
    go_wrong();
    ASSERT_TRUE(watch->more_scans(3000));
    watch->end();
    EXPECT_EQ(watch->wrong_scans(), 0);
    ASSERT_EQ(watch->gaps().size(), 1u);
    EXPECT_EQ(watch->gaps()[0].cause, cause);
    ASSERT_EQ(watch->jumps().size(), 1u);
    const auto& [before, after, came] = watch->jumps()[0];
    EXPECT_EQ(watch->gaps()[0].header.scans, after.index - before.index - 1);
    std::printf("a gap of %lld scans, %s\n", static_cast<long long>(watch->gaps()[0].header.scans),
                cause == GapCause::kDeviceGone ? "the device was gone" : "lost on the way");
  }
};

TEST_F(UsbBoardTest, FiftyTimesUnpluggedIsFiftyDeclaredGapsOfTheirTrueLength) {
  constexpr int kTimes = 50;
  boards.plug();
  open();
  ASSERT_TRUE(watch->more_scans(2000));
  std::vector<MachineTime> plugged;
  std::vector<double> truth_scans;
  std::vector<std::size_t> in_use;  // [replug] bytes
  std::size_t files = 0;
  plugged.reserve(kTimes), truth_scans.reserve(kTimes), in_use.reserve(kTimes);
  for (int k = 0; k < kTimes; ++k) {
    MachineTime first{}, second{};
    boards.with(0, [&](test::BenchBoard& board) { first = board.conversion_time(0); });
    boards.unplug();
    std::this_thread::sleep_for(20ms);
    boards.plug();
    plugged.push_back(MachineClock::now());
    ASSERT_TRUE(test::wait_until([&] { return count(DeviceCounter::kReturned) == k + 1; }, 10.0)) << k;
    ASSERT_TRUE(watch->more_scans(200)) << k;
    boards.with(0, [&](test::BenchBoard& board) { second = board.conversion_time(0); });
    truth_scans.push_back(1e-9 * static_cast<double>((second - first).count()) * kRateHz * (1.0 + 30e-6));
    in_use.push_back(bytes_in_use());
    if (k == 9) files = open_files();
  }
  // Other contents of a moment, e.g. the text of a search that failed, are not there every time.
  const auto early = std::min_element(in_use.end() - 30, in_use.end() - 15);
  const auto late = std::min_element(in_use.end() - 15, in_use.end());
  const auto grown = static_cast<std::ptrdiff_t>(*late - *early);
  watch->end();
  EXPECT_EQ(watch->wrong_scans(), 0);
  ASSERT_EQ(watch->gaps().size(), static_cast<std::size_t>(kTimes));
  ASSERT_EQ(watch->jumps().size(), static_cast<std::size_t>(kTimes));
  double slowest_s = 0.0;
  for (std::size_t k = 0; k < watch->jumps().size(); ++k) {
    const auto& [before, after, came] = watch->jumps()[k];
    EXPECT_EQ(watch->gaps()[k].cause, GapCause::kDeviceGone);
    EXPECT_EQ(watch->gaps()[k].header.scans, after.index - before.index - 1);
    EXPECT_TRUE(after.after_absence);
    // Had the board stayed, the runs' first scans would be so many apart.
    const std::int64_t first = before.index - before.counts[0], second = after.index - after.counts[0];
    EXPECT_NEAR(static_cast<double>(second - first), truth_scans[k], 1.0) << k;
    slowest_s = std::max(slowest_s, 1e-9 * static_cast<double>((came - plugged[k]).count()));
  }
  EXPECT_LT(slowest_s, 1.0);
  EXPECT_EQ(count(DeviceCounter::kGone), kTimes);
  expect_only({DeviceCounter::kGone, DeviceCounter::kReturned});
  EXPECT_LE(open_files(), files);
#ifndef __SANITIZE_ADDRESS__  // which has a heap of its own, and finds leaks to the byte
  EXPECT_TRUE(std::getenv("GLIBC_TUNABLES")) << "is not set; see the CMakeLists.txt of this program";
  EXPECT_LT(grown, 15 * 16) << "in fifteen times: less than the smallest block each";
#endif
  std::printf("%d times: scans again %.3f s after plugging in at the latest; memory grew by %td bytes\n",
              kTimes, slowest_s, grown);
}

TEST_F(UsbBoardTest, AHaltedEndpointIsClearedAndTheBoardsRingLosesNothing) {
  boards.plug();
  open();
  ASSERT_TRUE(watch->more_scans(1000));
  for (int k = 1; k <= 5; ++k) {
    boards.faults().stall = 1;
    ASSERT_TRUE(test::wait_until([&] { return count(DeviceCounter::kStalls) == k; }, 5.0));
    ASSERT_TRUE(watch->more_scans(500));
  }
  watch->end();
  EXPECT_EQ(watch->gaps().size(), 0u);
  EXPECT_EQ(watch->wrong_scans(), 0);
  expect_only({DeviceCounter::kStalls});
}

TEST_F(UsbBoardTest, ACutPacketIsAGap) {
  expect_one_gap([&] { boards.faults().cut = 1; }, GapCause::kDeviceOverrun);
  EXPECT_EQ(count(DeviceCounter::kShortPackets), 1);
  EXPECT_EQ(count(DeviceCounter::kPacketsMissing), 1);
  expect_only({DeviceCounter::kShortPackets, DeviceCounter::kPacketsMissing});
}

TEST_F(UsbBoardTest, ASpoiledPacketIsAGap) {
  expect_one_gap([&] { boards.faults().corrupt = 1; }, GapCause::kDeviceOverrun);
  EXPECT_EQ(count(DeviceCounter::kPacketsRefused), 1);
  expect_only({DeviceCounter::kPacketsRefused, DeviceCounter::kPacketsMissing});
}

TEST_F(UsbBoardTest, PacketsThatNeverComeAreAGap) {
  expect_one_gap([&] { boards.faults().drop = 3; }, GapCause::kDeviceOverrun);
  EXPECT_EQ(count(DeviceCounter::kPacketsMissing), 3);
  expect_only({DeviceCounter::kPacketsMissing});
}

TEST_F(UsbBoardTest, WhatTheBoardHadNoRoomForIsAGap) {
  // The endpoint is not served for longer than the board's ring holds, 205 ms.
  expect_one_gap([&] { boards.with(0, [](test::BenchBoard&) { std::this_thread::sleep_for(400ms); }); },
                 GapCause::kDeviceOverrun);
  EXPECT_EQ(count(DeviceCounter::kBoardOverrun), watch->gaps()[0].header.scans);
  expect_only({DeviceCounter::kBoardOverrun});
}

TEST_F(UsbBoardTest, WhatTheNodeDoesNotFetchIsAGap) {
  expect_one_gap(
      [&] {
        watch->hold(true);
        std::this_thread::sleep_for(2500ms);
        watch->hold(false);
        ASSERT_TRUE(watch->more_scans(15'000));  // first comes what was kept, of 1.3 s
      },
      GapCause::kDeviceOverrun);
  EXPECT_GT(count(DeviceCounter::kReadersTooSlow), 100);
  expect_only({DeviceCounter::kReadersTooSlow});
}

TEST_F(UsbBoardTest, ABoardThatDoesNotSayItsTimeIsCountedAndNotAskedAllTheTime) {
  boards.plug();
  open();
  ASSERT_TRUE(watch->more_scans(1000));
  boards.faults().deaf = 1000;
  ASSERT_TRUE(test::wait_until([&] { return count(DeviceCounter::kClockUnanswered) == 1; }, 5.0));
  ASSERT_TRUE(watch->more_scans(20'000));
  boards.faults().deaf = 0;
  watch->end();
  EXPECT_EQ(count(DeviceCounter::kClockUnanswered), 1)
      << "in two seconds, of which a question takes half a one";
  EXPECT_EQ(watch->gaps().size(), 0u);
  EXPECT_EQ(watch->wrong_scans(), 0);
  expect_only({DeviceCounter::kClockUnanswered});
}

TEST_F(UsbBoardTest, ASilentBoardIsStartedAgain) {
  // Its firmware has forgotten its run, e.g. after a watchdog's reset; the endpoint stays there.
  expect_one_gap([&] { boards.with(0, [](test::BenchBoard& board) { board.reset(); }); },
                 GapCause::kDeviceGone);
  EXPECT_EQ(count(DeviceCounter::kGone), 1);
  EXPECT_EQ(count(DeviceCounter::kReturned), 1);
}

TEST_F(UsbBoardTest, AConverterThatStopsIsSaidAndStartedAgain) {
  // The board lives and sends; its third start brings the converter back.
  constexpr int kStarts = 3;
  expect_one_gap(
      [&] {
        boards.with(0, [](test::BenchBoard& board) { board.halt_converter(kStarts); });
        ASSERT_TRUE(test::wait_until([&] { return count(DeviceCounter::kReturned) == 1; }, 20.0));
      },
      GapCause::kDeviceGone);
  EXPECT_GT(watch->gaps()[0].header.scans, kStarts * static_cast<std::int64_t>(kRateHz));
  expect_only({DeviceCounter::kGone, DeviceCounter::kReturned});
  EXPECT_EQ(count(DeviceCounter::kGone), 1) << "in vain started again it is still the same";
  ASSERT_EQ(said().size(), 1U);
  EXPECT_NE(said()[0].find("its converter stands still"), std::string::npos) << said()[0];
}

TEST_F(UsbBoardTest, ABoardThatAnotherProgramLeftRunningIsTakenOver) {
  boards.plug();
  open();
  ASSERT_TRUE(watch->more_scans(100));
  watch.reset();
  front_end.reset();
  open();
  ASSERT_TRUE(watch->more_scans(1000));
  watch->end();
  EXPECT_EQ(watch->wrong_scans(), 0);
  expect_only({});
}

}  // namespace
}  // namespace roadbalance
