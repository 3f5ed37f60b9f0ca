#include "host/analysis/orders/grid_join.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kPeriod_ns = 500'000;
constexpr double kTone_hz = 40.0, kFull = 4e6;

/// A block of a node whose clock shows `offset_ns` at the host's zero; channel 0 a tone of the host's time.
SealedBlock block_of(std::int32_t node, std::int64_t first_scan, std::int64_t offset_ns,
                     std::int32_t quality = 0, std::int64_t later_ns = 0) {
  ScanBlock block;
  block.header = {node,
                  7,
                  1 + first_scan / kScansPerBlock,
                  first_scan,
                  kScansPerBlock,
                  offset_ns + later_ns + first_scan * kPeriod_ns};
  block.period_ps = kPeriod_ns * 1000;
  block.quality = quality;
  for (std::size_t row = 0; row < kScansPerBlock; ++row) {
    const double t =
        1e-9 * static_cast<double>(later_ns + (first_scan + static_cast<std::int64_t>(row)) * kPeriod_ns);
    block.counts[row][0] =
        static_cast<std::int32_t>(std::lround(kFull * std::sin(2 * std::numbers::pi * kTone_hz * t)));
    block.counts[row][1] = static_cast<std::int32_t>(first_scan + static_cast<std::int64_t>(row));
  }
  SealedBlock sealed;
  seal(block, sealed);
  return sealed;
}

const NodeConfig kFour{.name = "four", .id = 4, .rate_hz = 2000.0, .channel = {}};
const NodeConfig kFive{.name = "five", .id = 5, .rate_hz = 2000.0, .channel = {}};

TEST(GridJoin, HandsOverASingleNodesScansUnchanged) {
  std::vector<int> seen;
  int restarts = 0;
  GridJoin join({&kFour}, [&](const GridJoin::Row& row) {
    seen.push_back(static_cast<int>((*row.sample[0].counts)[1]));
    restarts += row.restart;
  });
  for (const std::int64_t first : {0, 20, 60}) join.consume(block_of(4, first, 0));
  join.consume(block_of(9, 80, 0));  // not asked for
  ASSERT_EQ(seen.size(), 60U);
  for (int i = 0; i < 40; ++i) EXPECT_EQ(seen[static_cast<std::size_t>(i)], i);
  EXPECT_EQ(seen[40], 60);
  EXPECT_EQ(restarts, 2) << "at the beginning and after the hole";
}

TEST(GridJoin, BringsTwoNodesToOneInstantHoweverTheirBlocksInterleave) {
  std::vector<double> off;
  GridJoin join({&kFour, &kFive}, [&](const GridJoin::Row& row) {
    off.push_back(static_cast<double>((*row.sample[0].counts)[1] - (*row.sample[1].counts)[1]));
  });
  for (std::int64_t first = 0; first < 200; first += 20) join.consume(block_of(4, first, 0));
  EXPECT_TRUE(off.empty()) << "the other node has said nothing";
  for (std::int64_t first = 0; first < 200; first += 20)
    if (first != 100) join.consume(block_of(5, first, 0));
  EXPECT_EQ(off.size(), 180U);
  for (const double scans : off) EXPECT_EQ(scans, 0.0);
}

TEST(GridJoin, PassesOnEachNodesQuality) {
  std::vector<std::int32_t> quality;
  GridJoin join({&kFour, &kFive}, [&](const GridJoin::Row& row) {
    quality.push_back(row.sample[0].quality);
    EXPECT_EQ(row.sample[1].quality, kQualityUncertainAngle1);
  });
  for (std::int64_t first = 0; first < 60; first += 20) {
    join.consume(block_of(4, first, 0, first == 20 ? kQualityNoReference0 : 0));
    join.consume(block_of(5, first, 0, kQualityUncertainAngle1));
  }
  ASSERT_EQ(quality.size(), 60U);
  EXPECT_EQ(quality[19], 0);
  EXPECT_EQ(quality[20], kQualityNoReference0);
  EXPECT_EQ(quality[40], 0);
}

TEST(GridJoin, ComparesNodesWhoseClocksRunApartByTheirFits) {
  // Node 5's clock shows 3.3 s more than the host's, and it samples 0.2 ms later than node 4 does.
  constexpr std::int64_t kOffset_ns = 3'300'000'000, kLater_ns = 200'000;
  double most = 0.0;
  int rows = 0;
  GridJoin join({&kFour, &kFive}, [&](const GridJoin::Row& row) {
    ++rows;
    const double difference = (*row.sample[0].counts)[0] - (*row.sample[1].counts)[0];
    most = std::max(most, std::abs(difference) / kFull);
  });
  for (const std::int32_t node : {4, 5})
    join.consume(ClockFit{.node = node,
                          .epoch = 7,
                          .state = ClockState::kLocked,
                          .host_ns = 0,
                          .node_ns = node == 5 ? kOffset_ns : 0});
  for (std::int64_t first = 0; first < 2000; first += 20) {
    join.consume(block_of(4, first, 0));
    join.consume(block_of(5, first, kOffset_ns, 0, kLater_ns));
  }
  EXPECT_EQ(join.refusal(), "");
  EXPECT_GT(rows, 1900);
  // 0.2 ms of 40 Hz uncorrected would be 0.05.
  EXPECT_LT(most, 1e-4) << "the interpolation is right to 3e-5";
}

TEST(GridJoin, SaysWhatStandsInTheWayWhoeverSentLast) {
  int rows = 0;
  GridJoin join({&kFour, &kFive}, [&](const GridJoin::Row&) { ++rows; });
  // Node 5 takes 2500 scans a second.
  const auto of_five = [](std::int64_t first) {
    ScanBlock block = decode_scan(block_of(5, first, 0));
    block.header.time_ns = first * 400'000;
    block.period_ps = 400'000'000;
    SealedBlock sealed;
    seal(block, sealed);
    return sealed;
  };
  join.consume(block_of(4, 0, 0));
  join.consume(of_five(0));
  for (const std::int32_t last : {4, 5, 4}) {
    join.consume(last == 4 ? block_of(4, 20, 0) : of_five(20));
    EXPECT_NE(join.refusal().find("node 5: its samples have another rate"), std::string::npos)
        << "node " << last << " sent last: " << join.refusal();
  }
  EXPECT_EQ(rows, 0);
}

}  // namespace
}  // namespace roadbalance
