#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/bus/codec.hpp"
#include "firmware/block_packer.hpp"
#include "firmware/test/sealed_epoch.hpp"
#include "firmware/test/valve.hpp"

// An epoch begins and ends at instants by the device's clock, however the device is read.
namespace roadbalance {
namespace {

using test::kEpoch;
using test::kRate_hz;

NodeTime at(double seconds) {
  return node_time_from_ns(std::llround(seconds * 1e9));
}

/// A packer and its blocks.  The device is read in runs of `run` scans.
struct Read {
  explicit Read(std::int64_t run_of) : run(run_of) {}
  void pass(double until_s) {
    for (const std::int64_t until = std::llround(until_s * kRate_hz); now < until;) {
      const std::int64_t next = std::min(until, now + run);
      const auto scans = test::marked_scans(now, next, kRate_hz);
      std::vector<Edge> edges;
      for (; edge < all_edges.size() && all_edges[edge].time <= scans.back().time; ++edge)
        edges.push_back(all_edges[edge]);
      packer.asked(scans.back().time);
      packer.add(scans, edges, false);
      now = next;
    }
  }
  std::vector<SealedBlock> of(BlockKind kind) const {
    std::vector<SealedBlock> found;
    for (const SealedBlock& block : valve.blocks)
      if (block.kind == kind) found.push_back(block);
    return found;
  }
  std::vector<Edge> edges_kept() const {
    std::vector<Edge> edges;
    for (const SealedBlock& block : of(BlockKind::kEdge))
      for (const Edge& of_block : decode_edge(block).unpack()) edges.push_back(of_block);
    return edges;
  }
  /// Every scan of the epoch is that of the device with this number behind `first`.
  void expect_scans_from(std::int64_t first) const {
    for (const SealedBlock& block : of(BlockKind::kScan)) {
      const ScanBlock scans = decode_scan(block);
      for (std::int64_t i = 0; i < scans.header.scans; ++i)
        EXPECT_EQ(scans.counts[static_cast<std::size_t>(i)][0],
                  test::marked_counts(first + scans.header.first_scan + i, 0));
    }
  }

  const std::int64_t run;
  const VehicleConfig vehicle = test::one_node_vehicle(kRate_hz);
  const std::vector<Edge> all_edges = test::turning(6.0);
  test::Valve valve;
  BlockPacker packer{vehicle, vehicle.node[0], kEpoch, valve, nullptr};
  std::int64_t now = 0;  ///< in scans
  std::size_t edge = 0;
};

TEST(StartInstant, IsThatOfTheFirstScanAndEdgeKept) {
  for (const std::int64_t run : {1, 7, 64, 256}) {
    Read node(run);
    node.pass(0.9);
    node.packer.start(at(1.2));  // a first estimate
    node.pass(0.95);
    node.packer.start(at(1.00013));
    node.pass(1.6);
    EXPECT_TRUE(node.packer.started());
    node.packer.start(at(1.5));  // it has begun
    node.packer.stop(at(1.70013));
    node.pass(2.0);
    ASSERT_TRUE(node.packer.finish());
    EXPECT_EQ(node.of(BlockKind::kGap).size(), 0u);
    node.expect_scans_from(2001);  // the first behind the instant
    const EndBlock end = decode_end(node.valve.blocks.back());
    EXPECT_EQ(end.scans_sealed, 1400);
    EXPECT_EQ(end.scans_missing, 0);
    std::vector<Edge> expected;
    for (const Edge& edge : node.all_edges)
      if (edge.time >= at(1.00013) && edge.time < at(1.70013)) expected.push_back(edge);
    EXPECT_EQ(node.edges_kept().size(), expected.size());
    EXPECT_EQ(node.edges_kept().front().time, expected.front().time);
    EXPECT_EQ(node.edges_kept().back().time, expected.back().time);
  }
}

TEST(StartInstant, OfALateStartBeginsTheEpochWithWhatItMisses) {
  Read node(64);
  node.pass(1.5);
  node.packer.start(at(1.2));
  EXPECT_TRUE(node.packer.started());
  node.pass(2.0);
  node.packer.stop();
  node.packer.device_ended();
  ASSERT_TRUE(node.packer.finish());
  const auto gaps = node.of(BlockKind::kGap);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(decode_gap(gaps[0]).cause, GapCause::kStartedLate);
  EXPECT_EQ(gaps[0].header.first_scan, 0);
  EXPECT_EQ(gaps[0].header.scans, 600);
  EXPECT_EQ(gaps[0].header.time_ns, to_ns(at(1.2)));
  node.expect_scans_from(2400);
  EXPECT_TRUE(decode_scan(node.of(BlockKind::kScan).front()).quality & kQualityAfterGap);
  EXPECT_EQ(node.packer.counts().scans_missing, 600);
}

TEST(StartInstant, OfADeviceThatIsSilentIsWhereItsAbsenceBegins) {
  Read node(64);
  node.packer.start(at(1.0));
  for (double now = 0.0; now < 4.0; now += 0.05) node.packer.asked(at(now));
  EXPECT_TRUE(node.packer.started());
  node.now = 8000;
  node.pass(4.5);
  node.packer.stop();
  node.packer.device_ended();
  ASSERT_TRUE(node.packer.finish());
  const auto gaps = node.of(BlockKind::kGap);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(decode_gap(gaps[0]).cause, GapCause::kDeviceGone);
  EXPECT_EQ(gaps[0].header.scans, 6000);
}

TEST(StartInstant, DeclaresWhatADeviceLosesAroundIt) {
  Read node(64);
  node.pass(0.9);
  node.packer.start(at(1.0));
  node.now = 2200;  // the device lost scans 1800 to 2199
  node.pass(1.5);
  node.packer.stop();
  node.packer.device_ended();
  ASSERT_TRUE(node.packer.finish());
  const auto gaps = node.of(BlockKind::kGap);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(decode_gap(gaps[0]).cause, GapCause::kDeviceOverrun);
  EXPECT_EQ(gaps[0].header.scans, 200);
  node.expect_scans_from(2000);
}

TEST(StartInstant, OfASilentDeviceEndsItsAbsence) {
  Read node(64);
  node.packer.start();
  node.pass(1.0);
  node.packer.stop(at(3.0));
  for (double now = 1.0; now < 4.0; now += 0.05) node.packer.asked(at(now));
  node.packer.device_ended();
  ASSERT_TRUE(node.packer.finish());
  const auto gaps = node.of(BlockKind::kGap);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(decode_gap(gaps[0]).cause, GapCause::kDeviceGone);
  EXPECT_EQ(gaps[0].header.scans, 4000);
}

TEST(StartInstant, OfAStopIsNotThatOfAStartThatNobodyHeard) {
  Read node(64);
  node.pass(0.5);
  node.packer.stop(at(0.7));
  node.pass(1.5);
  ASSERT_TRUE(node.packer.finish());
  EXPECT_EQ(decode_end(node.valve.blocks.back()).scans_sealed, 0);
  EXPECT_EQ(node.of(BlockKind::kScan).size() + node.of(BlockKind::kGap).size(), 0u);
}

TEST(StartInstant, ThatDoesNotComeBeforeTheStopMakesAnEpochWithoutScans) {
  Read node(64);
  node.pass(0.5);
  node.packer.start(at(0.9));
  node.packer.stop(at(0.7));
  node.pass(1.5);
  ASSERT_TRUE(node.packer.finish());
  EXPECT_EQ(decode_end(node.valve.blocks.back()).scans_sealed, 0);
  EXPECT_EQ(node.of(BlockKind::kScan).size() + node.of(BlockKind::kGap).size(), 0u);
}

}  // namespace
}  // namespace roadbalance
