#include "common/record/segment_index.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <limits>
#include <system_error>

#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_events.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"

namespace roadbalance::test {
namespace {

const std::filesystem::path kFolder = "/drive";

class SegmentIndexTest : public ::testing::Test {
 protected:
  SegmentIndexTest() {
    Feeder feeder({.folder = kFolder, .segment_bytes = 8 << 10}, disk);
    feeder.append_through(60);
    feeder.close();
    holds = feeder.writer().holds().epoch;
    numbers = segment_numbers(kFolder, disk);
  }

  SimulatedDisk disk;
  std::map<NodeEpoch, RecordState::Epoch> holds;
  std::vector<int> numbers;
};

TEST_F(SegmentIndexTest, IsReadAsItWasWrittenAndRefusedWithAnyByteChanged) {
  const SegmentIndex index{
      .segment = 3,
      .bytes = 67'000'001,
      .epoch = {{{2, -7}, {.position = {.contiguous = 5, .next_scan = 90}, .samples = 80}}}};
  const std::string text = encode(index);
  EXPECT_EQ(decode_index(text), index);
  for (std::size_t at = 0; at < text.size(); ++at) {
    std::string altered = text;
    altered[at] = static_cast<char>(altered[at] ^ 1);
    EXPECT_FALSE(decode_index(altered)) << "byte " << at;
    EXPECT_FALSE(decode_index(text.substr(0, at))) << "cut at " << at;
  }
}

// Its CRC may be good nevertheless: a reader that counts on from there must come to an end.
TEST_F(SegmentIndexTest, NoNumberThatTheWireRefusesIsBelieved) {
  RecordState::Epoch highest;
  highest.position = {.contiguous = kIndexLimit, .next_scan = kIndexLimit};
  highest.samples = highest.gaps = highest.blocks = kIndexLimit;
  const auto is_believed = [](const RecordState::Epoch& epoch) {
    return decode_index(encode(SegmentIndex{.segment = 3, .bytes = 100, .epoch = {{{2, 7}, epoch}}}))
        .has_value();
  };
  EXPECT_TRUE(is_believed(highest));
  for (const std::int64_t number :
       {kIndexLimit + 1, std::numeric_limits<std::int64_t>::max(), std::int64_t{-1}})
    for (int field = 0; field < 5; ++field) {
      RecordState::Epoch epoch = highest;
      auto& [contiguous, next_scan, ended, crashed] = epoch.position;
      std::int64_t* const fields[] = {&contiguous, &next_scan, &epoch.samples, &epoch.gaps, &epoch.blocks};
      *fields[field] = number;
      EXPECT_FALSE(is_believed(epoch)) << field << ": " << number;
    }
}

TEST_F(SegmentIndexTest, EveryFinishedSegmentHasOneThatSaysWhereItEnds) {
  ASSERT_GT(numbers.size(), 3u);
  for (const int number : numbers) EXPECT_TRUE(read_index(kFolder, number, disk)) << number;
  EXPECT_EQ(read_index(kFolder, numbers.back(), disk)->epoch, holds);
}

TEST_F(SegmentIndexTest, ARestartReadsOnlyBehindTheLastOne) {
  std::int64_t segments_read = 0;
  disk.set_fault([&](DiskCall call, std::int64_t, const std::string& path) -> SimulatedDisk::Outcome {
    segments_read += call == DiskCall::kOpen && path.ends_with("seg-000001.lcm") ? 1 : 0;
    return {};
  });
  Feeder feeder({.folder = kFolder}, disk);
  EXPECT_EQ(feeder.found(), 60);
  EXPECT_EQ(segments_read, 0) << "the first segment was opened";
}

TEST_F(SegmentIndexTest, OneThatIsGoneOrWrongIsMadeAgainAndNeverBelieved) {
  SegmentIndex wrong = *read_index(kFolder, numbers.back(), disk);
  wrong.bytes -= 1;
  wrong.epoch.begin()->second.position.contiguous = 1000;
  write_index(kFolder, wrong, disk);
  disk.unlink(index_path(kFolder, 2).c_str());
  std::vector<UnsureBlock> unsure;
  const RecordState before = read_state(kFolder, disk, {}, &unsure);
  const std::int64_t sure = before.epoch.begin()->second.position.contiguous;
  EXPECT_EQ(unsure.empty() ? sure : unsure.back().block.header.sequence, 60);
  EXPECT_EQ(rebuild_indexes(kFolder, disk).written, 2);
  EXPECT_EQ(read_state(kFolder, disk).epoch, holds);
  EXPECT_EQ(rebuild_indexes(kFolder, disk).written, 0);
  EXPECT_EQ(read_index(kFolder, numbers.back(), disk)->epoch, holds);
}

// Made again, it would call what is left the whole.
TEST_F(SegmentIndexTest, OneThatKnowsOfMoreThanItsSegmentHasIsKept) {
  const int last = numbers.back();
  const std::string known = encode(*read_index(kFolder, last, disk));
  auto bytes = disk.content(segment_path(kFolder, last));
  bytes.resize(bytes.size() - commit_event_bytes());
  disk.put(segment_path(kFolder, last), bytes);
  EXPECT_EQ(rebuild_indexes(kFolder, disk).written, 0);
  Feeder feeder({.folder = kFolder}, disk);
  EXPECT_EQ(feeder.found(), 60);
  feeder.close();
  const auto kept = read_index_alone(kFolder, last, disk);
  ASSERT_TRUE(kept);
  EXPECT_EQ(encode(*kept), known);
}

// An index would call the segment finished, and what a kill left of it damage, for every reader and for good.
TEST_F(SegmentIndexTest, NoneIsMadeOfASegmentWhoseTailIsTorn) {
  const int last = numbers.back();
  for (const int number : {numbers.front(), last}) disk.unlink(index_path(kFolder, number).c_str());
  auto bytes = disk.content(segment_path(kFolder, last));
  bytes.insert(bytes.end(), 100, 'x');
  disk.put(segment_path(kFolder, last), bytes);
  const RebuiltIndexes rebuilt = rebuild_indexes(kFolder, disk);
  EXPECT_EQ(rebuilt.written, 1) << "that of the first one";
  EXPECT_EQ(rebuilt.torn, std::vector{segment_path(kFolder, last)});
  EXPECT_FALSE(path_exists(index_path(kFolder, last), disk));
  Feeder feeder({.folder = kFolder}, disk);
  ASSERT_TRUE(feeder.writer().cut_tail());
  EXPECT_EQ(feeder.writer().cut_tail()->cut, 100u);
  EXPECT_EQ(feeder.found(), 60);
}

TEST_F(SegmentIndexTest, ARestartGoesOnBehindDeletedSegmentsThoughNoneThatIsLeftHasAnIndex) {
  for (const int number : numbers)
    if (number != numbers.back()) delete_segment(kFolder, number, disk);
  disk.unlink(index_path(kFolder, numbers.back()).c_str());
  std::vector<UnsureBlock> unsure;
  const RecordState state = read_state(kFolder, disk, {}, &unsure);
  ASSERT_EQ(state.epoch.size(), 1u);
  const std::int64_t sure = state.epoch.begin()->second.position.contiguous;
  EXPECT_GT(sure, 1);
  EXPECT_EQ(unsure.empty() ? sure : unsure.back().block.header.sequence, 60);
  Feeder feeder({.folder = kFolder}, disk);
  EXPECT_EQ(feeder.found(), 60);
  EXPECT_EQ(feeder.writer().holds().epoch, holds);
  EXPECT_EQ(read_index(kFolder, numbers.back(), disk)->epoch, holds);
}

// Where it is not known what came before, a count from there on would be less than the indexes that are good.
TEST_F(SegmentIndexTest, AGoodOneStaysWhereItsBeginningIsInAnotherFolder) {
  disk.put((kFolder / kContinuesFile).string(), {'/', 'a', '\n'});
  std::map<int, std::string> before;
  for (const int number : numbers) before[number] = encode(*read_index(kFolder, number, disk));
  disk.unlink(index_path(kFolder, numbers.front()).c_str());
  disk.unlink(index_path(kFolder, numbers.back()).c_str());
  const RebuiltIndexes rebuilt = rebuild_indexes(kFolder, disk);
  EXPECT_EQ(rebuilt.written, 1) << "that of the last one, which follows good ones";
  EXPECT_EQ(rebuilt.unknown, std::vector{segment_path(kFolder, numbers.front())});
  for (const int number : numbers) {
    if (number == numbers.front()) continue;
    EXPECT_EQ(encode(*read_index(kFolder, number, disk)), before[number]) << number;
  }
}

TEST_F(SegmentIndexTest, OfADeletedSegmentTheOneStaysThatKnowsOfMore) {
  const int first = numbers.front();
  const std::string known = encode(*read_index(kFolder, first, disk));
  auto bytes = disk.content(segment_path(kFolder, first));
  bytes.resize(bytes.size() / 2);
  disk.put(segment_path(kFolder, first), bytes);
  delete_segment(kFolder, first, disk);
  EXPECT_EQ(encode(*read_index_alone(kFolder, first, disk)), known);
}

TEST_F(SegmentIndexTest, ARecordBeginsBehindTheSegmentDeletedLastThoughNumbersWereGivenUpSince) {
  const int first = numbers.front(), second = numbers[1];
  const auto index = read_index(kFolder, first, disk);
  delete_segment(kFolder, first, disk);
  disk.unlink(segment_path(kFolder, second).c_str());
  disk.unlink(index_path(kFolder, second).c_str());
  const RecordBeginning begin = beginning_of(kFolder, disk);
  ASSERT_TRUE(begin.before);
  EXPECT_EQ(*begin.before, *index);
  delete_segment(kFolder, numbers[2], disk);
  EXPECT_FALSE(path_exists(index_path(kFolder, first), disk));
  EXPECT_EQ(beginning_of(kFolder, disk).before->segment, numbers[2]);
}

TEST_F(SegmentIndexTest, NoSegmentIsDeletedWhoseIndexCannotBeMade) {
  for (const int number : numbers) disk.unlink(index_path(kFolder, number).c_str());
  disk.set_fault([](DiskCall call, std::int64_t, const std::string& path) -> SimulatedDisk::Outcome {
    return {.error = call == DiskCall::kOpen && path.ends_with(".idx.new") ? EIO : 0};
  });
  EXPECT_THROW(delete_segment(kFolder, numbers.front(), disk), std::system_error);
  EXPECT_EQ(segment_numbers(kFolder, disk), numbers);
  disk.set_fault(nullptr);
  for (const int number : numbers)
    if (number != numbers.back()) delete_segment(kFolder, number, disk);
  EXPECT_EQ(Feeder({.folder = kFolder}, disk).writer().holds().epoch, holds);
}

TEST_F(SegmentIndexTest, OfTwoFoldersTheLargerPositionCounts) {
  const NodeEpoch key = holds.begin()->first;
  RecordState ahead;
  ahead.epoch[key].position.contiguous = 70;
  EXPECT_EQ(start_from_index(kFolder, ahead, disk), numbers.back() + 1);
  EXPECT_EQ(ahead.epoch.at(key).position.contiguous, 70);
  RecordState behind;
  behind.epoch[key].position.contiguous = 50;
  behind.epoch[{9, 9}].blocks = 1;
  start_from_index(kFolder, behind, disk);
  EXPECT_EQ(behind.epoch.at(key), holds.at(key));
  EXPECT_EQ(behind.epoch.size(), 2u) << "what only the other folder knows";
}

// Events behind the end of an abandoned segment were never called durable, and are given again in the next
// one.
TEST(AbandonedSegment, EndsWhereTheNextOneSays) {
  SimulatedDisk disk;
  Feeder feeder({.folder = kFolder}, disk);
  ASSERT_TRUE(feeder.append_through(10) && feeder.sync());
  ASSERT_TRUE(feeder.append_through(20));
  bool cut_refused = true;
  disk.set_fault([&](DiskCall call, std::int64_t, const std::string&) -> SimulatedDisk::Outcome {
    const bool fails = cut_refused && (call == DiskCall::kSyncData || call == DiskCall::kTruncate);
    if (call == DiskCall::kTruncate) cut_refused = false;
    return {.error = fails ? EIO : 0};
  });
  ASSERT_TRUE(feeder.sync());
  ASSERT_TRUE(feeder.close());
  disk.set_fault(nullptr);
  EXPECT_EQ(segment_numbers(kFolder, disk), (std::vector<int>{1, 2}));
  const FoundBlocks found = find_blocks(kFolder, disk);
  EXPECT_EQ(found.sequences, all_through(20));
  EXPECT_TRUE(found.damage.empty());

  SegmentReader raw(segment_path(kFolder, 1), disk);
  std::vector<RecordReader::Damage> damage;
  int events = 0;
  while (raw.next(true, damage)) ++events;
  EXPECT_GT(events, 11) << "the cut was refused, so the blocks are still there";
}

}  // namespace
}  // namespace roadbalance::test
