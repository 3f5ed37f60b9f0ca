#include "host/recording/verify/block_runs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace roadbalance {
namespace {

constexpr std::int64_t kScans = 20;

BlockEntry scan_block(std::int64_t sequence) {
  return {.sequence = sequence,
          .first_scan = (sequence - 1) * kScans,
          .scans = kScans,
          .crc = static_cast<std::uint32_t>(sequence * 2654435761)};
}

std::vector<BlockEntry> in_order(const BlockRuns& runs) {
  std::vector<BlockEntry> all;
  runs.in_order([&](const BlockEntry& entry) { all.push_back(entry); });
  return all;
}

std::vector<BlockEntry> in_order(const std::vector<BlockEntry>& arrived) {
  BlockRuns runs;
  for (const BlockEntry& entry : arrived) runs.add(entry);
  return in_order(runs);
}

std::vector<BlockEntry> sorted(std::vector<BlockEntry> entries) {
  std::stable_sort(entries.begin(), entries.end(),
                   [](const BlockEntry& a, const BlockEntry& b) { return a.sequence < b.sequence; });
  return entries;
}

TEST(BlockRuns, HasNothingAtFirst) {
  EXPECT_TRUE(BlockRuns().empty());
  EXPECT_TRUE(in_order(BlockRuns()).empty());
}

TEST(BlockRuns, TellsWhatCameInOrderAsItCame) {
  std::vector<BlockEntry> arrived;
  for (std::int64_t n = 1; n <= 20'000; ++n) arrived.push_back(scan_block(n));
  EXPECT_EQ(in_order(arrived), arrived);
}

// Everything that breaks the order: repairs, repetitions, other contents of the same number, gaps, ends,
// other lengths.
TEST(BlockRuns, IsAStableSortByNumber) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::mt19937 random(seed);
    const auto chance = [&](unsigned of) { return random() % of == 0; };
    std::vector<BlockEntry> arrived;
    std::int64_t next = 1;
    for (int k = 0; k < 500; ++k) {
      if (chance(20))
        next = std::max<std::int64_t>(1, next + static_cast<std::int64_t>(random() % 400) - 250);
      BlockEntry entry = scan_block(next++);
      if (chance(30)) entry.kind = BlockKind::kGap, entry.cause = GapCause::kNodeCrash;
      if (chance(30)) entry.scans = static_cast<std::int64_t>(random() % 40);
      if (chance(30)) entry.first_scan += 7;
      if (chance(10)) entry.crc ^= 1;
      if (chance(60)) entry.kind = BlockKind::kEnd;
      arrived.push_back(entry);
    }
    ASSERT_EQ(in_order(arrived), sorted(arrived)) << "seed " << seed;
  }
}

TEST(BlockRuns, MixesABlockThatCameOnceMoreMuchLater) {
  std::vector<BlockEntry> arrived;
  for (std::int64_t n = 1; n <= 30'000; ++n) arrived.push_back(scan_block(n));
  arrived.push_back(scan_block(5000));
  arrived.back().crc ^= 1;
  for (std::int64_t n = 30'001; n <= 30'100; ++n) arrived.push_back(scan_block(n));
  EXPECT_EQ(in_order(arrived), sorted(arrived));
}

TEST(BlockRuns, TakesNumbersAtTheEndOfWhatANumberHolds) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  const std::vector<BlockEntry> arrived{{.sequence = kMost - 1, .first_scan = kMost - 3, .scans = 2},
                                        {.sequence = kMost, .first_scan = kMost - 1, .scans = 2},
                                        {.sequence = 1, .first_scan = kMost, .scans = kMost},
                                        {.sequence = 2, .first_scan = 0, .scans = kMost},
                                        {.sequence = 3, .first_scan = 0, .scans = kMost}};
  EXPECT_EQ(in_order(arrived), sorted(arrived));
}

}  // namespace
}  // namespace roadbalance
