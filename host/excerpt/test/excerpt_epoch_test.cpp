#include "host/excerpt/excerpt_epoch.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kRow_ns = 10'000'000, kSecond_ns = 1'000'000'000;
constexpr auto kEarliest = std::numeric_limits<std::int64_t>::min();

struct Seen {
  std::int64_t scans = 0, missing = 0, end_scan = -1;  ///< end_scan: of the epoch, when the piece was ended
};

class CountingSink : public EpochSink {
 public:
  CountingSink(Seen& seen, const std::int64_t& scan) : seen_(seen), scan_(scan) {}
  void scans(const ScanBlock& block) override { seen_.scans += block.header.scans; }
  void gap(std::int64_t scans, std::int64_t, GapCause) override { seen_.missing += scans; }
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

class ExcerptEpochTest : public testing::Test {
 protected:
  /// Blocks of 0.2 s, the first at begin_ns.
  std::map<std::size_t, Seen> cut(const Pieces& pieces, std::int64_t begin_ns, std::int64_t blocks) {
    std::map<std::size_t, Seen> seen;
    std::int64_t scan = 0;
    ExcerptEpoch epoch(clock_, pieces, kRow_ns * 1000, ~0U,
                       [&](std::size_t piece) { return std::make_unique<CountingSink>(seen[piece], scan); });
    for (std::int64_t k = 0; k < blocks; ++k) {
      scan = k * kScansPerBlock;
      epoch.take(block_at(k, begin_ns + scan * kRow_ns));
    }
    scan = blocks * kScansPerBlock;
    epoch.finish();
    return seen;
  }

 private:
  const EpochClock clock_{{1, 1}, std::nullopt, false};
};

/// Else a drive cut into thousands of pieces would hold a writer of each until it has been read whole.
TEST_F(ExcerptEpochTest, EndsAPieceOnceNothingOfItCanCome) {
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

TEST_F(ExcerptEpochTest, TakesTimesAsFarAwayAsTheyCanBeWritten) {
  for (const std::int64_t begin_ns : {kEarliest, kEarliest + 3 * kSecond_ns, std::int64_t{0}}) {
    const auto seen = cut({{kEarliest, Piece::kEver}}, begin_ns, 2);
    ASSERT_EQ(seen.size(), 1U) << begin_ns;
    EXPECT_EQ(seen.at(0).scans, 40) << begin_ns;
  }
}

}  // namespace
}  // namespace roadbalance
