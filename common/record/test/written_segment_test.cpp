#include "common/record/written_segment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <utility>

#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"

namespace roadbalance::test {
namespace {

const std::filesystem::path kFolder = "/drive";
constexpr std::uint64_t kSegmentBytes = 16 << 10;
constexpr std::int64_t kBlocks = 20;  // a segment and a part of the next

const RecordWriter::Options kOptions{.folder = kFolder, .segment_bytes = kSegmentBytes};

// On the disk, and nothing but tidy() is missing.
void write_two_segments(Feeder& feeder, SimulatedDisk& disk) {
  ASSERT_TRUE(feeder.append_through(kBlocks) && feeder.sync());
  ASSERT_EQ(segment_numbers(kFolder, disk), (std::vector<int>{1, 2}));
  ASSERT_FALSE(read_index(kFolder, 1, disk));
}

void expect_only_the_last_torn(const FoundBlocks& found) {
  for (const auto& piece : found.damage) {
    EXPECT_TRUE(piece.torn) << piece.segment << " at " << piece.offset << ": " << piece.what;
    EXPECT_EQ(piece.segment, segment_path(kFolder, 2)) << "the one before is all on the disk";
  }
}

using Calls = std::vector<std::pair<DiskCall, std::string>>;

// A file's calls bear the name that it was opened with, which for a segment ends in ".new".
bool finishes_the_first(const Calls& calls) {
  return std::any_of(calls.begin(), calls.end(), [](const auto& call) {
    const std::string name = call.second.substr(call.second.rfind('/') + 1);
    const bool changes =
        call.first == DiskCall::kTruncate || call.first == DiskCall::kSync || call.first == DiskCall::kWrite;
    return changes && (name.starts_with("seg-000001.idx") ||
                       (name.starts_with("seg-000001.lcm") && call.first != DiskCall::kWrite));
  });
}

TEST(WrittenSegment, WaitsForATimeWhenNobodyWaits) {
  Calls calls;  // the writer's end calls the disk, too
  SimulatedDisk disk;
  Feeder feeder(kOptions, disk);
  ASSERT_TRUE(feeder.append_through(1) && feeder.sync());
  disk.set_fault([&](DiskCall call, std::int64_t, const std::string& path) {
    calls.emplace_back(call, path);
    return SimulatedDisk::Outcome{};
  });
  ASSERT_NO_FATAL_FAILURE(write_two_segments(feeder, disk));
  EXPECT_FALSE(finishes_the_first(calls));
  EXPECT_EQ(feeder.durable(), kBlocks);
  calls.clear();
  EXPECT_TRUE(feeder.writer().tidy());
  EXPECT_TRUE(finishes_the_first(calls));
  EXPECT_TRUE(read_index(kFolder, 1, disk));
  EXPECT_FALSE(feeder.writer().tidy()) << "that was all";
}

// With the space that is reserved behind it: eighteen failures once left 294 MB.
TEST(AbandonedSegment, IsCutAsSoonAsTheDiskLetsUs) {
  SimulatedDisk disk;
  Feeder feeder(kOptions, disk);
  ASSERT_TRUE(feeder.append_through(3) && feeder.sync());
  const std::string segment = segment_path(kFolder, 1).string();
  const std::size_t durable = disk.content(segment).size();
  int failing = 0;
  disk.set_fault([&](DiskCall call, std::int64_t, const std::string&) {
    const bool fails = failing > 0 && (call == DiskCall::kSyncData || call == DiskCall::kTruncate);
    return SimulatedDisk::Outcome{.error = fails ? EIO : 0};
  });
  failing = 1;
  ASSERT_TRUE(feeder.append_through(5));
  EXPECT_THROW(feeder.writer().sync(), std::system_error);
  feeder.writer().abandon({});
  ASSERT_GT(disk.content(segment).size(), durable) << "the disk refused to cut it";
  failing = 0;
  ASSERT_TRUE(feeder.append_through(5) && feeder.sync());
  while (feeder.writer().tidy()) continue;
  EXPECT_EQ(disk.content(segment).size(), durable);
  ASSERT_TRUE(feeder.close());
}

TEST(WrittenSegment, IsFinishedByTheNextOneOrTheEndAtTheLatest) {
  SimulatedDisk disk;
  Feeder feeder(kOptions, disk);
  ASSERT_NO_FATAL_FAILURE(write_two_segments(feeder, disk));
  while (!path_exists(segment_path(kFolder, 3), disk))
    ASSERT_TRUE(feeder.append_through(feeder.appended() + 1));
  EXPECT_TRUE(read_index(kFolder, 1, disk));
  EXPECT_FALSE(read_index(kFolder, 2, disk));
  ASSERT_TRUE(feeder.close());
  EXPECT_TRUE(read_index(kFolder, 2, disk));
  EXPECT_TRUE(read_index(kFolder, 3, disk));
}

TEST(WrittenSegment, GivesBackWhatWasReservedBehindItsEnd) {
  SimulatedDisk disk;
  Feeder feeder(kOptions, disk);
  ASSERT_NO_FATAL_FAILURE(write_two_segments(feeder, disk));
  const std::int64_t reserved = disk.used_bytes();
  ASSERT_TRUE(feeder.writer().tidy());
  EXPECT_LT(disk.used_bytes(), reserved - (8 << 20)) << "of 16 MiB a segment of 16 KiB needs few";
}

TEST(WrittenSegment, ThatAKillLeftUnfinishedIsReadAsItIsAndFinishedByTheNextStart) {
  SimulatedDisk disk;
  {
    Feeder feeder(kOptions, disk);
    ASSERT_NO_FATAL_FAILURE(write_two_segments(feeder, disk));
    disk.kill();
  }
  const FoundBlocks found = find_blocks(kFolder, disk);
  EXPECT_EQ(found.sequences, all_through(kBlocks));
  EXPECT_TRUE(found.damage.empty());
  {
    const Feeder again(kOptions, disk);
    EXPECT_EQ(again.found(), kBlocks);
  }
  EXPECT_TRUE(read_index(kFolder, 1, disk));
  EXPECT_TRUE(read_index(kFolder, 2, disk));
  EXPECT_LT(disk.used_bytes(), 1 << 20) << "what was reserved behind both is given back";
}

TEST(WrittenSegment, LosesNothingToAPowerCutBeforeItIsFinished) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SimulatedDisk disk(seed);
    Feeder feeder(kOptions, disk);
    ASSERT_NO_FATAL_FAILURE(write_two_segments(feeder, disk));
    ASSERT_TRUE(feeder.append_through(kBlocks + 3));
    disk.cut_power();
    disk.power_on();
    const FoundBlocks found = find_blocks(kFolder, disk);
    expect_only_the_last_torn(found);
    const auto count = static_cast<std::int64_t>(found.sequences.size());
    ASSERT_GE(count, kBlocks) << "seed " << seed;
    ASSERT_EQ(found.sequences, all_through(count)) << "seed " << seed;
  }
}

// Whichever call of tidy() fails, and if the power goes at it.
TEST(WrittenSegment, TakesNothingFromTheRecordWhenItCannotBeFinished) {
  using Outcome = SimulatedDisk::Outcome;
  for (const Outcome outcome :
       {Outcome{.error = EIO}, Outcome{.error = ENOSPC}, Outcome{.power_cut = true}}) {
    std::int64_t k = 1;
    for (bool reached = true; reached; ++k) {
      SimulatedDisk disk(static_cast<std::uint64_t>(k));
      Feeder feeder(kOptions, disk);
      ASSERT_NO_FATAL_FAILURE(write_two_segments(feeder, disk));
      const std::int64_t before = disk.calls();
      disk.set_fault(SimulatedDisk::at_call(before + k, outcome));
      EXPECT_TRUE(feeder.writer().tidy());
      reached = disk.calls() >= before + k;
      EXPECT_FALSE(feeder.writer().has_failed());
      disk.set_fault(nullptr);
      if (!disk.is_off()) {
        ASSERT_TRUE(feeder.append_through(kBlocks + 5) && feeder.sync()) << "call " << k;
        disk.cut_power();
      }
      const std::int64_t durable = feeder.durable();
      disk.power_on();
      const FoundBlocks found = find_blocks(kFolder, disk);
      expect_only_the_last_torn(found);
      ASSERT_EQ(found.sequences, all_through(durable)) << "call " << k;
      EXPECT_EQ(Feeder(kOptions, disk).found(), durable) << "call " << k;
      EXPECT_TRUE(read_index(kFolder, 1, disk)) << "made by the start, call " << k;
    }
    EXPECT_GT(k, 8) << "tidying up has more calls than that";
  }
}

}  // namespace
}  // namespace roadbalance::test
