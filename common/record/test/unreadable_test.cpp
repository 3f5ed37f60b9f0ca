// A sector that cannot be read: a reader goes around it, a writer that decides what is durable does not.
#include <gtest/gtest.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "common/record/record_writer.hpp"
#include "common/record/rescue_disk.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"

namespace roadbalance {
namespace {

constexpr const char* kFolder = "/record";
constexpr std::uint64_t kBad = 20'000, kPage = 4096;
constexpr std::int64_t kBlocks = 100;

class UnreadableTest : public ::testing::Test {
 protected:
  void record(bool closes) {
    test::Feeder feeder({.folder = kFolder, .segment_bytes = 64 << 10}, disk);
    ASSERT_TRUE(feeder.append_through(kBlocks));
    ASSERT_TRUE(feeder.sync());
    if (closes) {
      ASSERT_TRUE(feeder.close());
    } else {
      disk.kill();
    }
  }
  std::string last_segment() { return segment_path(kFolder, segment_numbers(kFolder, disk).back()).string(); }

  test::SimulatedDisk disk;
  RescueDisk readable{disk};
};

// Only the events that have a byte in the page are lost.
TEST_F(UnreadableTest, AReaderLosesThePageAloneAndSaysWhy) {
  record(true);
  disk.spoil("/record/seg-000001.lcm", kBad);
  const std::uint64_t from = kBad / kPage * kPage, to = from + kPage;
  const test::FoundBlocks found = test::find_blocks(kFolder, readable);
  EXPECT_EQ(found.false_blocks, 0);
  EXPECT_TRUE(found.altered.empty());
  std::uint64_t unreadable = 0;
  for (const auto& piece : found.damage) {
    if (piece.what.starts_with("cannot be read")) {
      EXPECT_EQ(piece.what, "cannot be read: Input/output error");
      EXPECT_EQ(piece.offset, from);
      unreadable += piece.bytes;
    } else {
      EXPECT_TRUE(piece.offset + piece.bytes == from || piece.offset == to) << piece.offset;
    }
    EXPECT_FALSE(piece.torn);
  }
  EXPECT_EQ(unreadable, kPage);
  // A block takes some 1.4 kB: of those in the page and those that reach into it at both ends.
  EXPECT_GE(found.sequences.size(), static_cast<std::size_t>(kBlocks) - 12);
  EXPECT_LT(found.sequences.size(), static_cast<std::size_t>(kBlocks));
  EXPECT_EQ(found.sequences.back(), kBlocks);
}

TEST_F(UnreadableTest, WithoutItsIndexAllOfASegmentIsRead) {
  record(true);
  disk.spoil(index_path(kFolder, segment_numbers(kFolder, disk).back()).string(), 0);
  EXPECT_EQ(test::find_blocks(kFolder, readable).sequences, test::all_through(kBlocks));
}

// The sector may be readable again: nothing is cut where the end of what is durable is not known.
TEST_F(UnreadableTest, ARecorderDoesNotTakeItForTheEndOfATornSegment) {
  record(false);
  const std::string segment = last_segment();
  const auto names = disk.list(kFolder);
  const auto before = disk.content(segment);
  disk.spoil(segment, before.size() / 2);
  try {
    RecordWriter writer({.folder = kFolder}, disk);
    FAIL() << "taken over";
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code(), std::errc::io_error);
    EXPECT_NE(std::string(error.what()).find(segment), std::string::npos) << error.what();
  }
  EXPECT_EQ(disk.content(segment), before);
  EXPECT_EQ(disk.list(kFolder), names);
}

TEST_F(UnreadableTest, ARecorderDoesNotTakeAnIndexForNone) {
  record(true);
  const std::string segment = last_segment();
  const auto before = disk.content(segment);
  disk.spoil(index_path(kFolder, segment_numbers(kFolder, disk).back()).string(), 0);
  EXPECT_THROW(RecordWriter({.folder = kFolder}, disk), std::system_error);
  EXPECT_EQ(disk.content(segment), before);
}

}  // namespace
}  // namespace roadbalance
