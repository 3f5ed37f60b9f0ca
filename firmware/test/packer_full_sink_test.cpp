#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <vector>

#include "common/test/no_allocation.hpp"
#include "firmware/block_packer.hpp"
#include "firmware/test/sealed_epoch.hpp"
#include "firmware/test/valve.hpp"

// Edges and samples beside the scans when the sink is full: there exactly once, or inside a declared gap.
namespace roadbalance {
namespace {

using test::check_epoch;
using test::kEpoch;
using test::kRate_hz;
using test::turning;

constexpr std::int64_t kPeriod_ns = 500'000;
constexpr std::int64_t kScans = 2400;
constexpr std::size_t kRead = 40;

/// The device's scans.
struct Given {
  std::vector<Scan> scans;
  std::vector<Edge> edges;
  std::vector<SignalSample> signals;
  std::vector<Scan> scans_after;  ///< of the stop
  std::vector<Edge> edges_after;
};

Given driving(double turns_hz, double signals_hz, std::int64_t scans = kScans) {
  const double seconds = static_cast<double>(scans - 1) / kRate_hz;  // through the last scan
  Given given{.scans = test::marked_scans(0, scans, kRate_hz),
              .edges = turning(seconds, 0.0, turns_hz),
              .signals = {},
              .scans_after = test::marked_scans(scans, scans + 200, kRate_hz),
              .edges_after = turning(seconds + 0.1, seconds, turns_hz)};
  for (int k = 0; k < seconds * signals_hz; ++k)
    given.signals.push_back({node_time_from_ns(std::llround(1e9 * k / signals_hz)), 7, 1.0 * k});
  return given;
}

template <typename Item>
std::span<const Item> through(const std::vector<Item>& items, NodeTime time, std::size_t& next) {
  const std::size_t first = next;
  while (next < items.size() && items[next].time <= time) ++next;
  return std::span(items).subspan(first, next - first);
}

/// The sink is full after `places` blocks and has room again from scan `room_from` on, or at the end.
std::vector<SealedBlock> sealed(const Given& given, std::size_t places,
                                std::int64_t room_from = std::numeric_limits<std::int64_t>::max()) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  valve.places = places;
  valve.blocks.reserve(1000);
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  const auto is_full = [&] { return valve.places == 0; };
  const auto make_room = [&] { valve.places = std::numeric_limits<std::size_t>::max(); };
  {
    const test::NoAllocation guard;
    packer.start();
    std::size_t edge = 0, signal = 0;
    for (std::size_t i = 0; i < given.scans.size(); i += kRead) {
      if (given.scans[i].index >= room_from) make_room();
      const auto scans = std::span(given.scans).subspan(i, std::min(kRead, given.scans.size() - i));
      packer.add(through(given.signals, scans.back().time, signal));
      packer.add(scans, through(given.edges, scans.back().time, edge), false);
    }
    packer.stop();
    std::size_t later = 0;
    for (const Scan& scan : given.scans_after)
      packer.add({&scan, 1}, through(given.edges_after, scan.time, later), false);
    packer.device_ended();
    EXPECT_TRUE(packer.finish() || is_full());
    make_room();
    EXPECT_TRUE(packer.finish());
  }
  return valve.blocks;
}

template <typename Item>
std::vector<Item> recorded(const std::vector<SealedBlock>& blocks, BlockKind kind, auto&& decode) {
  std::vector<Item> all;
  for (const auto& block : blocks) {
    if (block.kind != kind) continue;
    const auto some = decode(block).unpack();
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

/// Stamps of what lies between the scan before a gap and the one behind it.
bool in_a_gap(NodeTime time, const std::vector<SealedBlock>& blocks) {
  return std::ranges::any_of(blocks, [&](const SealedBlock& block) {
    const std::int64_t end = block.header.first_scan + block.header.scans;
    return block.kind == BlockKind::kGap && to_ns(time) >= (block.header.first_scan - 1) * kPeriod_ns &&
           (end == kScans || to_ns(time) < end * kPeriod_ns);
  });
}

/// How many are not recorded.
int check_signals(const Given& given, const std::vector<SealedBlock>& blocks) {
  const auto there = recorded<SignalSample>(blocks, BlockKind::kSignal, decode_signal);
  int lost = 0;
  auto next = there.begin();
  for (const SignalSample& sample : given.signals)
    if (next != there.end() && next->time == sample.time && next->value == sample.value) {
      ++next;
    } else {
      ++lost;
      EXPECT_TRUE(in_a_gap(sample.time, blocks)) << "signal at " << to_ns(sample.time);
    }
  EXPECT_EQ(next, there.end());
  return lost;
}

/// The same of edges, where lost ones are marked besides.
int check_edges(const Given& given, const std::vector<SealedBlock>& blocks) {
  const auto there = recorded<Edge>(blocks, BlockKind::kEdge, decode_edge);
  int lost = 0;
  std::array<bool, kEncoderLines> hole{}, marked{};
  auto next = there.begin();
  for (const Edge& edge : given.edges) {
    for (; next != there.end() && next->kind == EdgeKind::kLost; ++next) marked[next->line] = true;
    if (next != there.end() && next->time == edge.time && next->line == edge.line &&
        next->kind == edge.kind) {
      EXPECT_EQ(marked[edge.line], hole[edge.line]) << "edge at " << to_ns(edge.time);
      hole[edge.line] = marked[edge.line] = false;
      ++next;
    } else {
      ++lost;
      hole[edge.line] = true;
      EXPECT_TRUE(in_a_gap(edge.time, blocks)) << "edge at " << to_ns(edge.time);
    }
  }
  EXPECT_EQ(next, there.end());
  return lost;
}

std::int64_t scans_missing(const std::vector<SealedBlock>& blocks) {
  return decode_end(blocks.back()).scans_missing;
}

TEST(FullSink, KeepsEdgesAndSignalsWhenTheLastScanTakesTheLastPlace) {
  // At some of these ends the last scan comes when edges or signals have just waited long enough.
  for (std::int64_t scans = 800; scans < 1300; scans += 3) {
    SCOPED_TRACE(scans);
    const Given given = driving(18.0, 30.0, scans);
    const auto all = sealed(given, 1000);
    const auto last = std::ranges::find(all.rbegin(), all.rend(), BlockKind::kScan, &SealedBlock::kind);
    const auto blocks = sealed(given, static_cast<std::size_t>(last->header.sequence));
    check_epoch(blocks, scans);
    EXPECT_EQ(scans_missing(blocks), 0);
    EXPECT_EQ(check_edges(given, blocks), 0);
    EXPECT_EQ(check_signals(given, blocks), 0);
  }
}

TEST(FullSink, HasEachEdgeAndSignalOnceOrInsideTheGapWhereverItFillsUp) {
  for (const double turns_hz : {0.0, 0.4, 4.0, 30.0}) {
    const Given given = driving(turns_hz, 300.0);
    const std::size_t all = sealed(given, 1000).size();
    int edges_lost = 0, signals_lost = 0;
    for (std::size_t places = 0; places <= all; ++places)
      for (const std::int64_t room_after : {40, 200, 1000, 5000}) {
        SCOPED_TRACE(testing::Message()
                     << turns_hz << " Hz, full after " << places << ", for " << room_after);
        const auto blocks = sealed(given, places, static_cast<std::int64_t>(places) * 17 + room_after);
        check_epoch(blocks, kScans);
        edges_lost += check_edges(given, blocks);
        signals_lost += check_signals(given, blocks);
        if (testing::Test::HasFailure()) return;
      }
    std::printf("%4.1f Hz: %d edges and %d signals lost\n", turns_hz, edges_lost, signals_lost);
    EXPECT_EQ(edges_lost > 0, turns_hz > 10.0) << "of a slow wheel all fit in one block";
    EXPECT_GT(signals_lost, 0);
  }
}

TEST(FullSink, LosesScansOnlyAsLongAsItMust) {
  const Given given = driving(18.0, 300.0);
  const auto blocks = sealed(given, 60, 1600);
  check_epoch(blocks, kScans);
  int gaps = 0;
  for (const auto& block : blocks)
    if (block.kind == BlockKind::kGap) {
      ++gaps;
      // It grows over what was waiting for its angle when there was room again.
      EXPECT_LE(block.header.first_scan + block.header.scans, 1600 + 2 * 100 + kScansPerBlock);
    }
  EXPECT_EQ(gaps, 1);
}

TEST(FullSink, DeclaresSamplesBehindTheLastScanWithAGapOfNone) {
  auto vehicle = test::one_node_vehicle(kRate_hz);
  for (auto& wheel : vehicle.wheel) wheel.node.clear();  // no angle is waited for
  const auto scans = test::marked_scans(0, 40, kRate_hz);
  test::Valve valve;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  packer.start();
  packer.add(scans, {}, false);
  valve.open = false;
  const std::vector<SignalSample> many(kSamplesPerBlock + 1, {scans.back().time, 7, 1.0});
  packer.add(many);
  packer.device_ended();
  EXPECT_FALSE(packer.finish());
  valve.open = true;
  ASSERT_TRUE(packer.finish());
  check_epoch(valve.blocks, 40);
  const auto& blocks = valve.blocks;
  const auto gap = std::ranges::find(blocks, BlockKind::kGap, &SealedBlock::kind);
  ASSERT_NE(gap, blocks.end());
  EXPECT_EQ(gap->header.first_scan, 40);
  EXPECT_EQ(gap->header.scans, 0);
  EXPECT_EQ(decode_gap(*gap).cause, GapCause::kRingFull);
  EXPECT_EQ(recorded<SignalSample>(blocks, BlockKind::kSignal, decode_signal).size(), many.size() - 1);
}

}  // namespace
}  // namespace roadbalance
