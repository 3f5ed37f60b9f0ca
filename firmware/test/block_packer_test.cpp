#include "firmware/block_packer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string_view>
#include <vector>

#include "common/bus/codec.hpp"
#include "firmware/test/sealed_epoch.hpp"
#include "firmware/test/valve.hpp"

namespace roadbalance {
namespace {

using test::blocks_of;
using test::check_epoch;
using test::kEpoch;
using test::kRate_hz;
using test::turning;

TEST(BlockPacker, TilesTheEpochAndEndsWithAShortBlockAndTotals) {
  const auto blocks = blocks_of(test::marked_scans(0, 1007, kRate_hz), turning(0.51));
  check_epoch(blocks, 1007);
  int metas = 0, shorts = 0;
  std::string text;
  for (const auto& block : blocks) {
    if (block.kind == BlockKind::kMeta) {
      ++metas;
      text += decode_meta(block).text;
    }
    if (block.kind == BlockKind::kScan && block.header.scans != kScansPerBlock) ++shorts;
  }
  EXPECT_EQ(blocks[0].kind, BlockKind::kMeta);
  EXPECT_EQ(metas, 3);
  EXPECT_EQ(text, test::one_node_vehicle().text);
  EXPECT_EQ(shorts, 1);
}

TEST(BlockPacker, RecordsEveryEdgeAsItCame) {
  const auto edges = turning(0.5);
  std::vector<Edge> recorded;
  for (const auto& block : blocks_of(test::marked_scans(0, 1000, kRate_hz), edges))
    if (block.kind == BlockKind::kEdge) {
      const auto some = decode_edge(block).unpack();
      recorded.insert(recorded.end(), some.begin(), some.end());
    }
  ASSERT_EQ(recorded.size(), edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    EXPECT_EQ(recorded[i].time, edges[i].time);
    EXPECT_EQ(recorded[i].line, edges[i].line);
    EXPECT_EQ(recorded[i].kind, edges[i].kind);
  }
}

// Header and CRC of their blocks shared, and those of the recorded event: 28 bytes and the channel's name.
// All but the last block of an epoch, which is as full as it is.
TEST(BlockPacker, KeepsARawEdgeInFourBytesFromFiveTurnsASecondOn) {
  constexpr std::size_t kOfEvent_bytes = 28 + std::string_view("RB_BLOCK_1_EDGE").size();
  struct Case {
    int teeth;
    double turns_hz, pitch_error_deg, jitter_s;
  };
  for (const Case& c : {Case{96, 5.0, 0.3, 10e-6}, Case{96, 18.0, 0.3, 10e-6}, Case{96, 18.0, 0.3, 100e-6},
                        Case{96, 30.0, 0.3, 10e-6}, Case{1000, 18.0, 0.01, 10e-6}}) {
    const sim::PulseTrain train{
        .angle_rad =
            [&](double t) { return 2.0 * std::numbers::pi * c.turns_hz * t + 0.3 * std::sin(1.3 * t); },
        .teeth = c.teeth,
        .pitch_error_rad = sim::pitch_errors(c.teeth, c.pitch_error_deg * std::numbers::pi / 180.0, 3),
        .jitter_s = c.jitter_s};
    const auto edges = train.edges(0.0, 8.0);
    std::size_t bytes = 0;
    std::int32_t recorded = 0;
    for (const auto& block : blocks_of(test::marked_scans(0, 16'000, kRate_hz), edges)) {
      if (block.kind != BlockKind::kEdge || block.header.first_scan == 16'000) continue;
      bytes += block.size + kOfEvent_bytes;
      recorded += decode_edge(block).edges;
    }
    const double of_an_edge = static_cast<double>(bytes) / recorded;
    EXPECT_LE(of_an_edge, 4.0) << c.teeth << " teeth at " << c.turns_hz << " Hz";
    EXPECT_GT(of_an_edge, 2.0) << "less than the entropy of such stamps";
  }
}

// A node that is killed loses what is not sealed.
TEST(BlockPacker, HoldsEdgesBackNoLongerThanTheyNeedToBeWorthABlock) {
  for (const double turns_hz : {0.5, 2.0, 5.0, 8.0, 18.0}) {
    const double edges_hz = 2.0 * 97.0 * turns_hz;  // of both wheels, with their marks
    double longest_s = 0.0;
    for (const auto& block :
         blocks_of(test::marked_scans(0, 16'000, kRate_hz), turning(7.9, 0.0, turns_hz))) {
      if (block.kind != BlockKind::kEdge || block.header.first_scan == 16'000) continue;
      const double sealed_s = static_cast<double>(block.header.first_scan) / kRate_hz;
      const double first_s = 1e-9 * static_cast<double>(to_ns(decode_edge(block).unpack().front().time));
      longest_s = std::max(longest_s, sealed_s - first_s);
    }
    std::printf("%4.0f edges/s: %.2f s\n", edges_hz, longest_s);
    // Looked at after each block of scans, which itself waits for the angle.
    EXPECT_LT(longest_s, std::max(0.2, std::min(1.0, 350.0 / edges_hz)) + 0.1) << turns_hz;
  }
}

TEST(BlockPacker, SealsTheSameBytesHoweverTheDeviceIsRead) {
  const auto scans = test::marked_scans(0, 3001, kRate_hz);
  const auto edges = turning(1.5);
  const auto once = blocks_of(scans, edges, 64), again = blocks_of(scans, edges, 7);
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i)
    EXPECT_TRUE(std::ranges::equal(once[i].bytes(), again[i].bytes())) << "block " << i;
}

TEST(BlockPacker, DeclaresScansTheDeviceLostWithTheirExactRange) {
  auto scans = test::marked_scans(0, 333, kRate_hz);
  const auto rest = test::marked_scans(1333, 2000, kRate_hz);
  scans.insert(scans.end(), rest.begin(), rest.end());
  const auto blocks = blocks_of(scans, turning(1.0));
  check_epoch(blocks, 2000);
  int gaps = 0;
  bool after = false;
  for (const auto& block : blocks) {
    if (block.kind == BlockKind::kScan) {
      EXPECT_EQ((decode_scan(block).quality & kQualityAfterGap) != 0, after);
      after = false;
    }
    if (block.kind != BlockKind::kGap) continue;
    ++gaps;
    after = true;
    EXPECT_EQ(block.header.first_scan, 333);
    EXPECT_EQ(block.header.scans, 1000);
    EXPECT_EQ(block.header.time_ns, 333 * 500'000);
    EXPECT_EQ(decode_gap(block).cause, GapCause::kDeviceOverrun);
  }
  EXPECT_EQ(gaps, 1);
}

TEST(BlockPacker, DeclaresWhatASourceOfKnownExtentLacksAtItsEnds) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  const auto at = [](int scan) { return node_time_from_ns(scan * 500'000); };
  for (const auto& [from, to] : {std::pair{0, 1'000}, {137, 1'000}, {0, 963}, {137, 963}, {999, 1'000}}) {
    std::vector<SealedBlock> blocks;
    EpochPacker packer(
        vehicle, vehicle.node[0], kEpoch, [&](const SealedBlock& block) { blocks.push_back(block); },
        GapCause::kSourceGap);
    packer.begin_at(0, at(0));
    packer.add(test::marked_scans(from, to, kRate_hz), {});
    packer.end_at(1'000, at(1'000));
    packer.end();
    std::vector<std::pair<std::int64_t, std::int64_t>> expected, gaps;
    if (from > 0) expected.emplace_back(0, from);
    if (to < 1'000) expected.emplace_back(to, 1'000 - to);
    std::int64_t next = 0;
    for (const auto& block : blocks) {
      if (block.kind == BlockKind::kMeta) continue;
      EXPECT_EQ(block.header.first_scan, next);
      EXPECT_EQ(block.header.time_ns, next * 500'000);
      next += block.header.scans;
      if (block.kind != BlockKind::kGap) continue;
      gaps.emplace_back(block.header.first_scan, block.header.scans);
      EXPECT_EQ(decode_gap(block).cause, GapCause::kSourceGap);
    }
    EXPECT_EQ(next, 1'000);
    EXPECT_EQ(gaps, expected);
    ASSERT_EQ(blocks.back().kind, BlockKind::kEnd);
    EXPECT_EQ(decode_end(blocks.back()).scans_sealed, to - from);
    EXPECT_EQ(decode_end(blocks.back()).scans_missing, 1'000 - (to - from));
  }
}

TEST(BlockPacker, KeepsTheOldestOfAFullSinkAndOneGapThatGrows) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  const auto edges = turning(2.0);
  const auto scans = test::marked_scans(0, 4000, kRate_hz);
  packer.start();
  std::size_t edge = 0;
  for (std::size_t i = 0; i < scans.size(); i += 50) {
    valve.open = i < 1000 || i >= 3000;
    const std::size_t first = edge;
    while (edge < edges.size() && edges[edge].time <= scans[i + 49].time) ++edge;
    packer.add(std::span(scans).subspan(i, 50), std::span(edges).subspan(first, edge - first), false);
  }
  packer.device_ended();
  ASSERT_TRUE(packer.finish());
  check_epoch(valve.blocks, 4000);
  int gaps = 0;
  for (const auto& block : valve.blocks)
    if (block.kind == BlockKind::kGap) {
      ++gaps;
      EXPECT_EQ(decode_gap(block).cause, GapCause::kRingFull);
      EXPECT_NEAR(static_cast<double>(block.header.scans), 2000.0,
                  3.0 * kScansPerBlock);  // whole blocks, lag
    }
  EXPECT_EQ(gaps, 1);
}

TEST(BlockPacker, WaitsWithTheEndForAFullSink) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  packer.start();
  packer.add(test::marked_scans(0, 45, kRate_hz), {}, false);
  valve.open = false;
  packer.device_ended();
  EXPECT_FALSE(packer.finish());
  valve.open = true;
  EXPECT_TRUE(packer.finish());
  check_epoch(valve.blocks, 45);
}

TEST(BlockPacker, DatesTheEndByTheLastKeptScanHoweverLongTheDeviceGoesOn) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  packer.start();
  packer.add(test::marked_scans(0, 45, kRate_hz), {}, false);
  packer.stop();
  packer.add(test::marked_scans(45, 2'000, kRate_hz), {}, false);
  ASSERT_TRUE(packer.finish());
  check_epoch(valve.blocks, 45);
  EXPECT_EQ(valve.blocks.back().header.time_ns, 45 * 500'000);
}

TEST(BlockPacker, CountsScansThatTheDeviceNumbersBackwards) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  packer.start();
  packer.add(test::marked_scans(0, 100, kRate_hz), {}, false);
  packer.add(test::marked_scans(93, 120, kRate_hz), {}, false);
  packer.device_ended();
  ASSERT_TRUE(packer.finish());
  check_epoch(valve.blocks, 120);
  EXPECT_EQ(packer.counts().scans_refused, 7);
}

// At ten scans a second blocks of edges and signals are cut by time, far from full.
TEST(BlockPacker, WritesNoMoreBlocksThanItAsksRoomFor) {
  constexpr double kSlow_hz = 10.0;
  const auto vehicle = test::one_node_vehicle(kSlow_hz);
  test::Valve valve;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  packer.start();
  const auto scans = test::marked_scans(0, 256, kSlow_hz);
  std::vector<Edge> edges;
  for (const Scan& scan : scans) edges.push_back({scan.time, 0, EdgeKind::kTooth});
  std::vector<SignalSample> signals;
  for (const Scan& scan : scans) signals.push_back({scan.time, 0, 1.0});
  const std::size_t most = packer.most_blocks(scans.size(), edges.size(), signals.size());
  packer.add(scans, edges, false);
  packer.add(signals);
  packer.device_ended();
  ASSERT_TRUE(packer.finish());
  EXPECT_LE(valve.blocks.size(), most);
}

TEST(BlockPacker, KeepsExactlyWhatLiesBetweenStartAndStop) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  PreviewSlot preview;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, &preview);
  const auto scans = test::marked_scans(0, 3000, kRate_hz);
  packer.add(std::span(scans).first(511), {}, false);
  EXPECT_TRUE(valve.blocks.empty());
  const SealedBlock* seen = preview.read();
  ASSERT_NE(seen, nullptr);
  EXPECT_EQ(seen->header.sequence, 0);
  packer.start();
  packer.start();
  packer.add(std::span(scans).subspan(511, 1000), {}, false);
  packer.stop();
  packer.add(std::span(scans).subspan(1511), {}, false);
  ASSERT_TRUE(packer.finish());
  std::int64_t kept = 0, first_ns = -1;
  for (const auto& block : valve.blocks)
    if (block.kind == BlockKind::kScan) {
      if (first_ns < 0) first_ns = block.header.time_ns;
      kept += block.header.scans;
    }
  EXPECT_EQ(first_ns, 511 * 500'000);
  EXPECT_EQ(kept, 1000);
  EXPECT_EQ(valve.blocks.back().kind, BlockKind::kEnd);
  EXPECT_EQ(valve.blocks.back().header.first_scan, 1000);
}

TEST(BlockPacker, SealsABlockAtStandstillWithin100MsAndSaysSo) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  packer.start();
  const auto edges = turning(1.0);  // then the pulses stop
  const auto scans = test::marked_scans(0, 4000, kRate_hz);
  std::size_t edge = 0;
  for (const Scan& scan : scans) {
    const std::size_t first = edge;
    while (edge < edges.size() && edges[edge].time <= scan.time) ++edge;
    packer.add({&scan, 1}, std::span(edges).subspan(first, edge - first), false);
    const auto newest = std::find_if(valve.blocks.rbegin(), valve.blocks.rend(),
                                     [](const SealedBlock& b) { return b.kind == BlockKind::kScan; });
    const std::int64_t sealed =
        newest == valve.blocks.rend() ? 0 : newest->header.first_scan + newest->header.scans;
    // 100 ms are 200 scans after the block's last one.
    ASSERT_LE(scan.index - sealed, 200 + kScansPerBlock) << "at scan " << scan.index;
  }
  constexpr std::int32_t kNone = kQualityNoReference0 | kQualityNoReference1;
  for (const auto& block : valve.blocks) {
    if (block.kind != BlockKind::kScan) continue;
    const ScanBlock scan = decode_scan(block);
    const double t = static_cast<double>(scan.header.time_ns) * 1e-9;
    if (t > 0.3 && t < 0.95) {
      EXPECT_EQ(scan.quality & kNone, 0) << t;
    }
    if (t > 1.02) {
      EXPECT_EQ(scan.quality & kNone, kNone) << t;
      for (std::size_t c = kAccelerations; c < kChannels; ++c) EXPECT_EQ(scan.counts[0][c], 0);
    }
  }
  EXPECT_GT(packer.counts().unreferenced_blocks, 80);
}

}  // namespace
}  // namespace roadbalance
