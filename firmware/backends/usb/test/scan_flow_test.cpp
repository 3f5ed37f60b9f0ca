#include "firmware/backends/usb/scan_flow.hpp"

#include <gtest/gtest.h>

#include "firmware/backends/usb/test/counting_bench.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using test::bench;
using test::BoardFeed;
using test::vehicle;

TEST(ScanFlow, ABoardWhoseConverterStandsStillIsDryThoughItSends) {
  BoardFeed feed({bench()}, vehicle());
  feed.begin();
  feed.run(2s);
  EXPECT_TRUE(feed.reader().flow(0).flows());
  EXPECT_FALSE(feed.reader().flow(0).is_dry());
  feed.board().halt_converter(2);
  feed.run(950ms);
  const std::size_t scans = feed.scans.size();
  EXPECT_FALSE(feed.reader().flow(0).is_dry());
  feed.run(200ms);  // of which each hundred milliseconds bring a packet
  EXPECT_TRUE(feed.reader().flow(0).is_dry());
  EXPECT_EQ(feed.scans.size(), scans);
  // Started again in vain, and again.
  feed.begin();
  feed.run(950ms);
  EXPECT_FALSE(feed.reader().flow(0).is_dry());
  feed.run(250ms);
  EXPECT_TRUE(feed.reader().flow(0).is_dry());
  EXPECT_FALSE(feed.reader().flow(0).flows());
  feed.begin();
  feed.run(1500ms);
  EXPECT_FALSE(feed.reader().flow(0).is_dry());
  EXPECT_TRUE(feed.reader().flow(0).flows());
  ASSERT_GT(feed.scans.size(), scans);
  EXPECT_TRUE(feed.scans[scans].after_absence);
  EXPECT_NEAR(static_cast<double>(feed.scans[scans].index - feed.scans[scans - 1].index),
              2.35 * test::kRateHz, 20.0);
}

TEST(ScanFlow, ABoardOfWhichNoPacketCanBeUsedIsDry) {
  BoardFeed feed({bench()}, vehicle());
  feed.begin();
  feed.run(1s);
  for (int k = 0; k < 220; ++k) {
    feed.shift_ticks = std::uint64_t{1} << 40;
    feed.run(5ms);
  }
  EXPECT_GT(feed.report().of(DeviceCounter::kPacketsRefused), 150);
  EXPECT_TRUE(feed.reader().flow(0).is_dry());
}

NodeTime at(int ms) {
  return node_time_from_ns(std::int64_t{ms} * 1'000'000);
}

TEST(ScanFlow, WhatTheNodeHadNoRoomForIsNoDrought) {
  ScanFlow flow;
  flow.take(at(0), true, true);
  flow.take(at(3000), false, false);
  EXPECT_FALSE(flow.is_dry());
  for (const int ms : {3800, 3900}) {
    flow.take(at(ms), false, true);
    EXPECT_FALSE(flow.is_dry());
  }
  flow.take(at(4001), false, true);
  EXPECT_TRUE(flow.is_dry());
}

TEST(ScanFlow, OneTransferInVainBehindAPauseIsNoDrought) {
  ScanFlow flow;
  flow.take(at(0), true, true);
  flow.take(at(5000), false, true);
  EXPECT_FALSE(flow.is_dry());
  flow.take(at(5001), true, true);
  EXPECT_FALSE(flow.is_dry());
}

}  // namespace
}  // namespace roadbalance
