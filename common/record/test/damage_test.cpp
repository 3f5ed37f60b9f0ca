#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <string_view>

#include "common/bus/codec.hpp"
#include "common/record/log_event.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"

namespace roadbalance::test {
namespace {

using Bytes = std::vector<std::uint8_t>;
const std::filesystem::path kFolder = "/drive";
const std::string kSegment = segment_path(kFolder, 1).string();

/// Where an event lies in the segment.
struct Piece {
  std::uint64_t begin;
  std::uint64_t end;
  std::int64_t sequence;  ///< of the block, or 0
};

class Damaged : public ::testing::Test {
 protected:
  // A finished segment, synced every fourth block.
  void record(std::int64_t bytes) {
    Feeder feeder({.folder = kFolder}, disk);
    while (static_cast<std::int64_t>(disk.content(kSegment).size()) < bytes - 1500) {
      feeder.append_through(feeder.appended() + 4);
      feeder.sync();
    }
    feeder.close();
    whole = disk.content(kSegment);
    last = feeder.appended();
    RecordReader reader(kFolder, disk);
    SealedBlock block;
    while (const auto event = reader.next()) {
      const bool is_block = accept(event->data, block) == Refusal::kNone;
      if (!pieces.empty()) pieces.back().end = reader.offset();
      pieces.push_back(
          {.begin = reader.offset(), .end = whole.size(), .sequence = is_block ? block.header.sequence : 0});
    }
  }

  // The sequences of the blocks that lie before `size` as a whole.
  std::int64_t last_before(std::uint64_t size) const {
    std::int64_t found = 0;
    for (const auto& piece : pieces)
      if (piece.end <= size) found = std::max(found, piece.sequence);
    return found;
  }

  void cut_to(std::uint64_t size) {
    disk.put(kSegment, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
  }

  // All complete events are there, nothing else, and the rest is listed to the byte.
  void expect_exactly_what_is_left(std::uint64_t size) {
    const FoundBlocks found = find_blocks(kFolder, disk);
    ASSERT_EQ(found.false_blocks, 0) << "cut at " << size;
    ASSERT_TRUE(found.altered.empty()) << "cut at " << size;
    ASSERT_EQ(found.sequences, all_through(last_before(size))) << "cut at " << size;
    std::uint64_t end = 0;
    for (const auto& piece : pieces)
      if (piece.end <= size) end = piece.end;
    ASSERT_EQ(found.damage.empty(), end == size) << "cut at " << size;
    if (found.damage.empty()) return;
    ASSERT_EQ(found.damage.size(), 1u) << "cut at " << size;
    ASSERT_EQ(found.damage[0].offset, end) << "cut at " << size;
    ASSERT_EQ(found.damage[0].bytes, size - end) << "cut at " << size;
  }

  SimulatedDisk disk;
  Bytes whole;
  std::vector<Piece> pieces;
  std::int64_t last = 0;
};

TEST_F(Damaged, CutAtEveryByteItGivesItsCompleteEventsAndListsTheRest) {
  record(64 << 10);
  ASSERT_GT(whole.size(), 60'000u);
  for (std::uint64_t size = 0; size <= whole.size(); ++size) {
    cut_to(size);
    ASSERT_NO_FATAL_FAILURE(expect_exactly_what_is_left(size));
  }
}

// RB_EVERY_BIT=1: around every event, at every byte; else around sixteen, at every eighth.
TEST_F(Damaged, CutAroundEveryEventOfALargeOneTheSame) {
  record(2 << 20);
  const bool everywhere = std::getenv("RB_EVERY_BIT") != nullptr;
  const std::size_t step = everywhere ? 1 : pieces.size() / 16;  // each cut reads 2 MiB
  for (std::size_t k = 0; k < pieces.size(); k += step)
    for (int off = -64; off <= 64; off += everywhere ? 1 : 8) {
      const auto size = static_cast<std::int64_t>(pieces[k].end) + off;
      if (size < 0 || size > static_cast<std::int64_t>(whole.size())) continue;
      cut_to(static_cast<std::uint64_t>(size));
      ASSERT_NO_FATAL_FAILURE(expect_exactly_what_is_left(static_cast<std::uint64_t>(size)));
    }
}

// The event that was hit, or that one of a few was: each commit answers for the headers before it.
bool is_listed(const Piece& hit, const FoundBlocks& found) {
  const bool is_damage =
      std::any_of(found.damage.begin(), found.damage.end(), [&](const RecordReader::Damage& damage) {
        return damage.offset == hit.begin && damage.bytes == hit.end - hit.begin && !damage.torn;
      });
  const bool is_header =
      std::any_of(found.altered_headers.begin(), found.altered_headers.end(),
                  [&](const auto& of) { return of.from <= hit.begin && hit.end <= of.to; });
  const bool is_altered = found.altered == std::vector{hit.begin};
  return is_altered || is_damage || is_header;
}

// Number, stamp and channel of the last event, a commit, have nothing behind them that answers for them.
bool is_unprotected(std::uint64_t byte, const Piece& last) {
  const std::uint64_t at = byte - last.begin;
  const std::uint64_t name = kLogHeaderBytes;
  return byte >= last.begin &&
         ((4 <= at && at < 20) || (name <= at && at < name + std::string_view(kCommitChannel).size()));
}

// RB_EVERY_BIT=1: all 524 288; else every seventh, which hits each bit of a byte.  Sync word, number, stamp,
// lengths, channel and data: whatever is hit is listed.
TEST_F(Damaged, AFlippedBitCostsAtMostTheEventItIsInAndThatIsListed) {
  record(64 << 10);
  const std::uint64_t step = std::getenv("RB_EVERY_BIT") ? 1 : 7;
  const std::vector<std::int64_t> all = all_through(last);
  auto hit = pieces.begin();
  for (std::uint64_t bit = 0; bit < 8 * whole.size(); bit += step) {
    while (bit / 8 >= hit->end) ++hit;
    disk.flip_bit(kSegment, bit);
    const FoundBlocks found = find_blocks(kFolder, disk);
    disk.flip_bit(kSegment, bit);
    ASSERT_EQ(found.false_blocks, 0) << "bit " << bit;
    std::vector<std::int64_t> without = all;
    std::erase(without, hit->sequence);
    const bool is_there = found.sequences == all;
    ASSERT_TRUE(is_there || found.sequences == without) << "bit " << bit;
    ASSERT_LE(found.damage.size() + found.altered.size(), 1u) << "bit " << bit;
    ASSERT_LE(found.altered_headers.size(), 1u) << "bit " << bit;
    ASSERT_TRUE(is_listed(*hit, found) || is_unprotected(bit / 8, pieces.back())) << "bit " << bit;
  }
}

// The tail of a segment that was finished is no torn tail: its index holds how long it was.
TEST_F(Damaged, WhatIsMissingBeforeACommitIsNoTornTail) {
  record(16 << 10);
  const Piece& middle = pieces[pieces.size() / 2];
  disk.flip_bit(kSegment, 8 * middle.begin);
  for (const bool with_index : {true, false}) {
    if (!with_index) disk.unlink(index_path(kFolder, 1).c_str());
    const FoundBlocks found = find_blocks(kFolder, disk);
    ASSERT_EQ(found.damage.size(), 1u);
    EXPECT_FALSE(found.damage[0].torn);
    EXPECT_EQ(found.damage[0].offset, middle.begin);
    EXPECT_EQ(found.damage[0].bytes, middle.end - middle.begin);
  }
}

}  // namespace
}  // namespace roadbalance::test
