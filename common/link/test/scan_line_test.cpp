#include "common/link/scan_line.hpp"

#include <gtest/gtest.h>

#include <optional>

namespace roadbalance {
namespace {

BlockHeader at(std::int64_t scan, std::int64_t time_ns) {
  return {.first_scan = scan, .scans = 20, .time_ns = time_ns};
}

TEST(ScanLine, LiesThroughTheBlocksBeforeAndBehind) {
  ScanLine line;
  line.take(BlockKind::kScan, at(0, 1000));
  const BlockHeader behind = at(100, 2000);
  EXPECT_EQ(line.time_ns(20, &behind), 1200);
}

TEST(ScanLine, WithoutABlockBehindGoesOnAsTheLastTwo) {
  ScanLine line;
  line.take(BlockKind::kScan, at(0, 1000));
  line.take(BlockKind::kGap, at(20, 3000));
  EXPECT_EQ(line.time_ns(40, nullptr), 5000);
  const BlockHeader before = at(10, 9000);
  EXPECT_EQ(line.time_ns(40, &before), 5000) << "what lies before tells nothing";
}

TEST(ScanLine, IsNotToldByBlocksWithoutScans) {
  ScanLine line;
  line.take(BlockKind::kScan, at(0, 1000));
  line.take(BlockKind::kScan, at(20, 3000));
  for (const BlockKind kind : {BlockKind::kEdge, BlockKind::kSignal, BlockKind::kMeta})
    line.take(kind, at(30, 0));
  EXPECT_EQ(line.time_ns(40, nullptr), 5000);
}

TEST(ScanLine, OfAnEpochThatHasNotBegunKnowsTheBlockBehindOnly) {
  const ScanLine line;
  const BlockHeader behind = at(100, 2000);
  EXPECT_EQ(line.time_ns(0, &behind), 2000);
  EXPECT_EQ(line.time_ns(0, nullptr), std::nullopt);
}

TEST(ScanLine, WhateverIsTakenEndsAtTheLimitOfAClock) {
  for (const std::int64_t sign : {-1, 1}) {
    ScanLine line;
    line.take(BlockKind::kScan, at(0, -sign * kClockLimit_ns));
    line.take(BlockKind::kScan, at(1, sign * kClockLimit_ns));
    EXPECT_EQ(line.time_ns(kIndexLimit, nullptr), sign * kClockLimit_ns);
  }
}

}  // namespace
}  // namespace roadbalance
