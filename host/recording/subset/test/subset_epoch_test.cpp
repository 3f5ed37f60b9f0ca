#include "host/recording/subset/subset_epoch.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <vector>

#include "common/bus/codec.hpp"
#include "host/recording/subset/epoch_writer.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kRow_ns = 10'000'000, kSecond_ns = 1'000'000'000;
constexpr auto kEarliest = std::numeric_limits<std::int64_t>::min();

struct Seen {
  std::int64_t scans = 0, gaps = 0, missing = 0,
               end_scan = -1;  ///< end_scan: of the epoch, when the piece was ended
  GapCause cause = GapCause::kNodeCrash;
};

class CountingSink : public EpochSink {
 public:
  CountingSink(Seen& seen, const std::int64_t& scan) : seen_(seen), scan_(scan) {}
  void scans(const ScanBlock& block) override { seen_.scans += block.header.scans; }
  void gap(std::int64_t scans, std::int64_t, GapCause cause) override {
    ++seen_.gaps;
    seen_.missing += scans;
    seen_.cause = cause;
  }
  void edges(std::span<const Edge>) override {}
  void signals(std::span<const SignalSample>) override {}
  void end(Ending) override { seen_.end_scan = scan_; }

 private:
  Seen& seen_;
  const std::int64_t& scan_;
};

SealedBlock block_at(std::int64_t number, std::int64_t time_ns) {
  ScanBlock block;
  block.header = {.node = 1,
                  .epoch = 1,
                  .sequence = number + 1,
                  .first_scan = number * kScansPerBlock,
                  .scans = kScansPerBlock,
                  .time_ns = time_ns};
  block.period_ps = kRow_ns * 1000;
  SealedBlock sealed;
  seal(block, sealed);
  return sealed;
}

class SubsetEpochTest : public testing::Test {
 protected:
  /// Blocks of 0.2 s, the first at begin_ns.
  std::map<std::size_t, Seen> cut(const Pieces& pieces, std::int64_t begin_ns, std::int64_t blocks) {
    std::map<std::size_t, Seen> seen;
    std::int64_t scan = 0;
    SubsetEpoch epoch(clock_, pieces, kRow_ns * 1000, ~0U,
                      [&](std::size_t piece) { return std::make_unique<CountingSink>(seen[piece], scan); });
    for (std::int64_t k = 0; k < blocks; ++k) {
      scan = k * kScansPerBlock;
      epoch.take(block_at(k, begin_ns + scan * kRow_ns));
    }
    scan = blocks * kScansPerBlock;
    epoch.finish();
    return seen;
  }

 protected:
  const EpochClock clock_{{1, 1}, std::nullopt, false};
};

TEST_F(SubsetEpochTest, DeclaresEdgesThatAreLostBetweenScans) {
  Seen seen;
  std::int64_t scan = 0;
  const Pieces pieces{{kEarliest, Piece::kEver}};
  SubsetEpoch epoch(clock_, pieces, kRow_ns * 1000, ~0U,
                    [&](std::size_t) { return std::make_unique<CountingSink>(seen, scan); });
  epoch.take(block_at(0, 0));
  GapBlock gap;
  gap.header = {.node = 1, .epoch = 1, .sequence = 2, .first_scan = kScansPerBlock, .time_ns = 20 * kRow_ns};
  SealedBlock sealed;
  seal(gap, sealed);
  epoch.take(sealed);
  epoch.finish();
  EXPECT_EQ(seen.gaps, 1);
  EXPECT_EQ(seen.missing, 0);
  EXPECT_EQ(seen.cause, GapCause::kRingFull);
}

/// Otherwise a drive cut into thousands of pieces would hold a writer for each until its end.
TEST_F(SubsetEpochTest, EndsAPieceOnceNothingOfItCanCome) {
  const Pieces pieces{{0, kSecond_ns}, {2 * kSecond_ns, 3 * kSecond_ns}, {20 * kSecond_ns, Piece::kEver}};
  const auto seen = cut(pieces, 0, 150);
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_EQ(seen.at(0).scans, 100);
  EXPECT_EQ(seen.at(1).scans, 100);
  EXPECT_EQ(seen.at(2).scans, 1000);
  EXPECT_GE(seen.at(0).end_scan, 230) << "edges and signals come 1.3 s behind their scans";
  EXPECT_LE(seen.at(0).end_scan, 1000);
  EXPECT_LE(seen.at(1).end_scan, 1000);
  EXPECT_EQ(seen.at(2).end_scan, 3000);
}

TEST_F(SubsetEpochTest, TakesTimesAsFarAwayAsTheyCanBeWritten) {
  for (const std::int64_t begin_ns : {kEarliest, kEarliest + 3 * kSecond_ns, std::int64_t{0}}) {
    const auto seen = cut({{kEarliest, Piece::kEver}}, begin_ns, 2);
    ASSERT_EQ(seen.size(), 1U) << begin_ns;
    EXPECT_EQ(seen.at(0).scans, 40) << begin_ns;
  }
}

/// Keeps when gaps began.
class GapTimes : public CountingSink {
 public:
  GapTimes(Seen& seen, const std::int64_t& scan, std::vector<std::int64_t>& times)
      : CountingSink(seen, scan), times_(times) {}
  void gap(std::int64_t scans, std::int64_t time_ns, GapCause cause) override {
    CountingSink::gap(scans, time_ns, cause);
    times_.push_back(time_ns);
  }

 private:
  std::vector<std::int64_t>& times_;
};

SealedBlock gap_at(std::int64_t number, std::int64_t first_scan, std::int64_t scans) {
  const GapBlock gap{
      .header = {.node = 1, .epoch = 1, .sequence = number + 1, .first_scan = first_scan, .scans = scans},
      .cause = GapCause::kRingFull};
  SealedBlock sealed;
  seal(gap, sealed);
  return sealed;
}

TEST(SubsetEpoch, GapsBeyondWhatClocksCanTellBeginAtTheirLimitAndNeverGoBack) {
  const EpochClock clock({1, 1}, std::nullopt, false);
  const Pieces pieces{{kEarliest, Piece::kEver}};
  constexpr std::int64_t kLost = kIndexLimit / 4;
  Seen seen;
  const std::int64_t scan = 0;
  std::vector<std::int64_t> times;
  SubsetEpoch epoch(clock, pieces, kRow_ns * 1000, ~0U,
                    [&](std::size_t) { return std::make_unique<GapTimes>(seen, scan, times); });
  epoch.take(block_at(0, 0));
  for (std::int64_t k = 0; k < 3; ++k) epoch.take(gap_at(k + 1, kScansPerBlock + k * kLost, kLost));
  epoch.take(gap_at(4, 0, 1));
  epoch.finish();
  EXPECT_EQ(seen.missing, 3 * kLost);
  EXPECT_EQ(times, (std::vector<std::int64_t>{kScansPerBlock * kRow_ns, kClockLimit_ns, kClockLimit_ns}));
}

TEST(EpochWriter, AnEndBehindAGapBeyondWhatClocksCanTellIsAtTheirLimit) {
  std::vector<SealedBlock> put;
  EpochWriter writer({1, 1}, "", [&](const SealedBlock& block) { put.push_back(block); });
  writer.scans(decode_scan(block_at(0, 0)));
  writer.gap(kIndexLimit / 2, kScansPerBlock * kRow_ns, GapCause::kRingFull);
  writer.end(EpochSink::Ending::kEnd);
  ASSERT_FALSE(put.empty());
  EXPECT_EQ(put.back().kind, BlockKind::kEnd);
  EXPECT_EQ(put.back().header.time_ns, kClockLimit_ns);
}

}  // namespace
}  // namespace roadbalance
