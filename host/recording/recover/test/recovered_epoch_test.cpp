#include "host/recording/recover/recovered_epoch.hpp"

#include <gtest/gtest.h>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kScans = 20;  // in each block

// The time of a scan on a clock that does not begin at scan 0, with another period than the nominal one.
std::int64_t time_ns(std::int64_t scan) {
  return 7'000'000'000 + 500'025 * scan;
}

BlockHeader header(std::int64_t sequence, std::int64_t first_scan) {
  return {.node = 1,
          .epoch = 77,
          .sequence = sequence,
          .first_scan = first_scan,
          .scans = 0,
          .time_ns = time_ns(first_scan)};
}

SealedBlock scans(std::int64_t sequence) {
  ScanBlock block;
  block.header = header(sequence, kScans * (sequence - 1));
  block.header.scans = kScans;
  block.period_ps = 500'000'000;
  SealedBlock sealed;
  seal(block, sealed);
  return sealed;
}

SealedBlock declared_gap(std::int64_t sequence, std::int64_t first_scan, std::int64_t scans, GapCause cause) {
  GapBlock gap{.header = header(sequence, first_scan), .cause = cause};
  gap.header.scans = scans;
  SealedBlock sealed;
  seal(gap, sealed);
  return sealed;
}

class RecoveredEpochTest : public ::testing::Test {
 protected:
  void put(std::int64_t sequence) { out.put(scans(sequence), 0, write); }

  RecoveredEpoch out;
  std::vector<BlockHeader> gaps;
  const RecoveredEpoch::Write write = [this](const SealedBlock& block, std::int64_t) {
    if (block.kind == BlockKind::kGap) gaps.push_back(block.header);
  };
};

TEST_F(RecoveredEpochTest, AGapBearsTheInstantOfItsFirstScan) {
  for (const std::int64_t sequence : {1, 2, 3, 7, 8, 10}) put(sequence);
  out.finish(write);
  ASSERT_EQ(gaps.size(), 2u);
  EXPECT_EQ(gaps[0].first_scan, 3 * kScans);
  EXPECT_EQ(gaps[0].time_ns, time_ns(3 * kScans));
  EXPECT_EQ(gaps[1].first_scan, 8 * kScans);
  EXPECT_EQ(gaps[1].time_ns, time_ns(8 * kScans));
}

TEST_F(RecoveredEpochTest, AGapBehindTheLastBlockBearsTheInstantThatTheRecorderDeclared) {
  out.declared(declared_gap(4, 2 * kScans, 2 * kScans, GapCause::kLostAtNode), 0);
  out.declared(declared_gap(5, 4 * kScans, 0, GapCause::kNodeCrash), 0);
  put(1);
  put(2);
  out.finish(write);
  ASSERT_EQ(gaps.size(), 2u);
  EXPECT_EQ(gaps[0].time_ns, time_ns(2 * kScans));
  EXPECT_EQ(gaps[1].first_scan, 4 * kScans);
  EXPECT_EQ(gaps[1].time_ns, time_ns(4 * kScans));
}

TEST_F(RecoveredEpochTest, AGapBeforeTheFirstBlockBearsThatOnesInstant) {
  put(3);
  out.finish(write);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(gaps[0].scans, 2 * kScans);
  EXPECT_EQ(gaps[0].time_ns, time_ns(2 * kScans)) << "as a recorder declares it";
}

}  // namespace
}  // namespace roadbalance
