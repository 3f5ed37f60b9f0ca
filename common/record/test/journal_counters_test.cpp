#include "common/record/journal_counters.hpp"

#include <gtest/gtest.h>

#include <random>

#include "common/bus/codec.hpp"
#include "common/types/crc32c.hpp"

namespace roadbalance {
namespace {

SealedBlock scans(std::int64_t sequence, std::int64_t first_scan, std::int64_t count, ScanBlock& block) {
  std::mt19937 random(static_cast<unsigned>(sequence));
  block.header = {.node = 2, .epoch = 7, .sequence = sequence, .first_scan = first_scan, .scans = count};
  block.period_ps = 500'000'000;
  for (auto& row : block.counts)
    for (auto& value : row) value = static_cast<std::int32_t>(random());
  SealedBlock sealed;
  seal(block, sealed);
  return sealed;
}

SealedBlock gap(std::int64_t sequence, std::int64_t first_scan, std::int64_t count, GapCause cause) {
  SealedBlock sealed;
  seal(
      GapBlock{
          .header = {.node = 2, .epoch = 7, .sequence = sequence, .first_scan = first_scan, .scans = count},
          .cause = cause},
      sealed);
  return sealed;
}

// The CRC of a column written out byte by byte, as in journal_t.lcm.
std::uint32_t column_crc(const std::vector<ScanBlock>& blocks, std::size_t channel) {
  std::vector<std::uint8_t> bytes;
  for (const auto& block : blocks)
    for (std::size_t row = 0; row < static_cast<std::size_t>(block.header.scans); ++row)
      for (int shift = 24; shift >= 0; shift -= 8)
        bytes.push_back(
            static_cast<std::uint8_t>(static_cast<std::uint32_t>(block.counts[row][channel]) >> shift));
  return crc32c_by_table(bytes);
}

TEST(JournalCounters, SaysWhatWasAppendedSinceTheEntryBefore) {
  JournalCounters counters;
  std::vector<ScanBlock> blocks(3);
  counters.add(scans(1, 0, 20, blocks[0]));
  counters.add(scans(2, 20, 7, blocks[1]));
  counters.add(gap(3, 27, 100, GapCause::kRingFull));
  EXPECT_EQ(counters.due(), (std::vector<NodeEpoch>{{2, 7}}));
  const Journal first = counters.take(2, 7);
  EXPECT_EQ(first.first_sequence, 1);
  EXPECT_EQ(first.last_sequence, 3);
  EXPECT_EQ(first.first_scan, 0);
  EXPECT_EQ(first.next_scan, 127);
  EXPECT_EQ(first.scans, 27);
  EXPECT_EQ(first.scans_missing, 100);
  for (std::size_t channel = 0; channel < kChannels; ++channel)
    EXPECT_EQ(first.channel_crc[channel], column_crc({blocks[0], blocks[1]}, channel));

  EXPECT_TRUE(counters.due().empty());
  counters.add(gap(6, 127, 40, GapCause::kLostAtNode));  // covers 4 and 5 too
  counters.add(scans(7, 167, 20, blocks[2]));
  const Journal second = counters.take(2, 7);
  EXPECT_EQ(second.first_sequence, 4);
  EXPECT_EQ(second.last_sequence, 7);
  EXPECT_EQ(second.first_scan, 127);
  EXPECT_EQ(second.next_scan, 187);
  EXPECT_EQ(second.channel_crc[5], column_crc({blocks[2]}, 5));

  const Journal empty = counters.take(2, 7);
  EXPECT_EQ(empty.first_sequence, 8);
  EXPECT_EQ(empty.last_sequence, 7);
  EXPECT_EQ(empty.first_scan, 187);
}

}  // namespace
}  // namespace roadbalance
