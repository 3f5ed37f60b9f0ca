#include <gtest/gtest.h>

#include "firmware/backends/usb/board_pair.hpp"
#include "firmware/backends/usb/test/counting_bench.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using test::Bench;
using test::bench;
using test::BoardFeed;
using test::counts_of;
using test::vehicle;

TEST(TwoBoards, GiveHalfOfTheChannelsEachOfTheSameConversion) {
  Bench second = bench(-40.0);
  second.serial = "BENCH2";
  second.words = [](std::int64_t conversion, MachineTime) {
    board::ScanWords words{};
    for (std::size_t k = 0; k < board::kInputChannels; ++k)
      words[k] = static_cast<std::uint32_t>(-counts_of(conversion, k)) & 0xFFFFFF;
    if (conversion == 50) words[2] = 0x7FFFFF;
    return words;
  };
  BoardFeed feed({bench(60.0), std::move(second)}, vehicle());
  feed.begin();
  feed.run(10s);
  ASSERT_GE(feed.scans.size(), 99'800u);
  EXPECT_TRUE(feed.reader().aligned());
  for (std::size_t k = 0; k < feed.scans.size(); ++k) {
    const Scan& scan = feed.scans[k];
    ASSERT_EQ(scan.index, static_cast<std::int64_t>(k));
    for (std::size_t c = 0; c < 6; ++c) {
      ASSERT_EQ(scan.counts[c], counts_of(scan.index, c));
      ASSERT_TRUE(k == 50 || scan.counts[6 + c] == -counts_of(scan.index, c));
    }
    ASSERT_EQ(scan.overload, k == 50 ? 1u << 8 : 0u);
  }
  const std::size_t before = feed.scans.size();
  feed.absent(100ms);
  feed.begin();
  feed.run(50ms);
  EXPECT_NEAR(static_cast<double>(feed.scans[before].index - feed.scans[before - 1].index), 1000.0, 60.0);
}

/// Two boards, of which the second is not fetched for a while.
BoardFeed two_boards() {
  return BoardFeed({bench(60.0), bench(-60.0)}, vehicle());
}

TEST(TwoBoards, WaitForTheOtherBoardAsLongAsThatKeepsItsScans) {
  BoardFeed feed = two_boards();
  feed.begin();
  feed.run(1s);
  feed.not_fetched = 1;
  feed.run(190ms);  // its ring holds 205
  feed.not_fetched = SIZE_MAX;
  feed.run(1s);
  ASSERT_GT(feed.scans.size(), 21'800u);
  for (std::size_t k = 0; k < feed.scans.size(); ++k)
    ASSERT_EQ(feed.scans[k].index, static_cast<std::int64_t>(k));
  for (std::size_t which = 0; which < 2; ++which)
    for (std::size_t k = 0; k < kDeviceCounters; ++k)
      EXPECT_EQ(feed.report(which).of(DeviceCounter(k)), 0) << which << sentence(DeviceCounter(k));
}

TEST(TwoBoards, CountTheScansThatGoBecauseTheOtherBoardsDoNotCome) {
  BoardFeed feed = two_boards();
  feed.begin();
  feed.run(1s);
  feed.not_fetched = 1;
  feed.run(600ms);
  const std::int64_t dropped = feed.report(1).of(DeviceCounter::kPartnerLate);
  // But for the scans of a packet that is not full yet.
  EXPECT_NEAR(static_cast<double>(dropped), 6000.0 - static_cast<double>(BoardPair::kScans), 30.0);
  EXPECT_EQ(feed.report(0).of(DeviceCounter::kPartnerLate), 0);
}

TEST(TwoBoards, SayHowOftenSyncBounced) {
  Bench follower = bench(-60.0);
  follower.bounces = [](std::int64_t conversion) {
    return conversion % 1000 == 500 ? std::optional(0.1) : std::nullopt;
  };
  BoardFeed feed({bench(60.0), std::move(follower)}, vehicle());
  feed.begin();
  feed.run(10s);
  EXPECT_EQ(feed.report(1).of(DeviceCounter::kGlitches), 100);
  EXPECT_EQ(feed.report(0).of(DeviceCounter::kGlitches), 0);
  for (std::size_t k = 0; k < feed.scans.size(); ++k)
    ASSERT_EQ(feed.scans[k].index, static_cast<std::int64_t>(k));
}

}  // namespace
}  // namespace roadbalance
