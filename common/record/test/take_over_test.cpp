#include "common/record/take_over.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/notes.hpp"
#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"

namespace roadbalance::test {
namespace {

const std::filesystem::path kFolder = "/drive";
constexpr std::int64_t kPromised = 20;
constexpr std::int64_t kWritten = 60;
constexpr std::uint64_t kSeeds = 40;

SimulatedDisk::Fault syncs_fail() {
  return [](DiskCall call, std::int64_t, const std::string&) -> SimulatedDisk::Outcome {
    return {.error = call == DiskCall::kSyncData ? EIO : 0};
  };
}

// A sync fails, and the recorder is killed before it could note in the next segment where this one ends.
void fail_and_be_killed(SimulatedDisk& disk) {
  Feeder feeder({.folder = kFolder}, disk);
  ASSERT_TRUE(feeder.append_through(kPromised) && feeder.sync());
  ASSERT_TRUE(feeder.append_through(kWritten));
  disk.set_fault(syncs_fail());
  EXPECT_THROW(feeder.writer().sync(), std::system_error);
  disk.kill();
  disk.set_fault(nullptr);
}

std::vector<std::int64_t> left_by_power_cut(SimulatedDisk& disk) {
  disk.cut_power();
  disk.power_on();
  return find_blocks(kFolder, disk).sequences;
}

// A start in the course of which the power goes, at its k-th call of the disk; then power again.  False if it
// was through before, with more than `least` calls.
bool power_goes_at_call(SimulatedDisk& disk, std::int64_t k, std::int64_t least) {
  disk.set_fault(SimulatedDisk::at_call(disk.calls() + k, {.power_cut = true}));
  bool taken = false;
  try {
    const Feeder feeder({.folder = kFolder}, disk);
    taken = !disk.is_off();
  } catch (const std::system_error&) {
  }
  disk.set_fault(nullptr);
  if (taken)
    EXPECT_GT(k, least) << "a take-over has more calls than that";
  else
    disk.power_on();
  return !taken;
}

TEST(TakeOver, WhatAFailedSyncLeftToThePageCacheIsOnTheDiskBeforeItCounts) {
  int torn = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SimulatedDisk untouched(seed);
    ASSERT_NO_FATAL_FAILURE(fail_and_be_killed(untouched));
    torn += std::ssize(left_by_power_cut(untouched)) < kWritten ? 1 : 0;

    SimulatedDisk disk(seed);
    ASSERT_NO_FATAL_FAILURE(fail_and_be_killed(disk));
    std::int64_t found = 0;
    {
      const Feeder feeder({.folder = kFolder}, disk);
      found = feeder.found();
    }
    EXPECT_EQ(found, kWritten) << "all could be read";
    EXPECT_EQ(left_by_power_cut(disk), all_through(found)) << "seed " << seed;
  }
  EXPECT_GT(torn, 0) << "no failed sync lost anything: this test proves nothing";
}

TEST(TakeOver, APowerCutMeanwhileTakesNothingThatWasPromised) {
  for (std::int64_t k = 1;; ++k) {
    SimulatedDisk disk(static_cast<std::uint64_t>(k));
    ASSERT_NO_FATAL_FAILURE(fail_and_be_killed(disk));
    if (!power_goes_at_call(disk, k, 10)) return;
    const auto left = find_blocks(kFolder, disk).sequences;
    ASSERT_GE(std::ssize(left), kPromised) << "call " << k;
    ASSERT_EQ(left, all_through(std::ssize(left))) << "call " << k;
  }
}

TEST(TakeOver, IsRefusedWhereTheDiskDoesNotTakeTheTailAgain) {
  SimulatedDisk disk;
  ASSERT_NO_FATAL_FAILURE(fail_and_be_killed(disk));
  disk.set_fault([](DiskCall call, std::int64_t, const std::string& path) -> SimulatedDisk::Outcome {
    return {.error = call == DiskCall::kSync && path.ends_with(".lcm") ? EIO : 0};
  });
  EXPECT_THROW(Feeder({.folder = kFolder}, disk), std::system_error);
  EXPECT_THROW(Feeder({.folder = kFolder}, disk), std::system_error) << "nor the second time";
  disk.kill();
  disk.set_fault(nullptr);
  EXPECT_EQ(Feeder({.folder = kFolder}, disk).found(), kWritten);
  EXPECT_EQ(left_by_power_cut(disk), all_through(kWritten));
}

TEST(TakeOver, AnIndexMadeAgainCountsNothingThatIsNotOnTheDisk) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SimulatedDisk disk(seed);
    ASSERT_NO_FATAL_FAILURE(fail_and_be_killed(disk));
    EXPECT_EQ(rebuild_indexes(kFolder, disk).written, 1);
    EXPECT_EQ(left_by_power_cut(disk), all_through(kWritten)) << "seed " << seed;
  }
}

// Turns a bit of the last byte of the k-th event, from 0 on, that `is_it`.
template <typename IsIt>
void damage_event(SimulatedDisk& disk, int k, IsIt&& is_it) {
  const auto path = segment_path(kFolder, 1).string();
  SegmentReader reader(path, disk);
  std::vector<RecordReader::Damage> none;
  for (auto event = reader.next(true, none); event; event = reader.next(true, none))
    if (is_it(*event) && k-- == 0) {
      auto bytes = disk.content(path);
      bytes[reader.end_of_events() - 1] ^= 1;
      return disk.put(path, bytes);
    }
  FAIL() << "there is no such event";
}

// A block on the disk rots; then the power goes at the close, and of the events written since the last sync
// the commit event of that sync is torn: only the last commit event, which goes with the tail, has shown that
// the block was there.
std::vector<std::int64_t> rot_and_tear(SimulatedDisk& disk) {
  {
    Feeder feeder({.folder = kFolder}, disk);
    EXPECT_TRUE(feeder.append_through(10) && feeder.sync() && feeder.append_through(20) && feeder.sync());
    EXPECT_TRUE(feeder.append_through(30));
    feeder.writer().close();
  }
  EXPECT_TRUE(remove_file(index_path(kFolder, 1), disk));
  SealedBlock block;
  damage_event(disk, 0, [&](const LogEvent& event) {
    return accept(event, block) == Refusal::kNone && block.header.sequence == 15;
  });
  damage_event(disk, 1, [](const LogEvent& event) { return event.channel == kCommitChannel; });
  std::vector<std::int64_t> left = all_through(20);
  std::erase(left, 15);
  EXPECT_EQ(find_blocks(kFolder, disk).sequences, left);
  return left;
}

TEST(TakeOver, DamageBeforeTheCutIsNoTornTailThoughItsCommitEventWasCutOff) {
  SimulatedDisk disk;
  const auto promised = rot_and_tear(disk);
  for (int starts = 1; starts <= 2; ++starts) {
    { const Feeder feeder({.folder = kFolder}, disk); }
    remove_file(index_path(kFolder, 1), disk);  // as if it was killed before it wrote one
    const FoundBlocks found = find_blocks(kFolder, disk);
    EXPECT_EQ(found.sequences, promised) << starts << " starts";
    EXPECT_TRUE(found.altered_headers.empty());
    EXPECT_EQ(found.altered.size() + found.damage.size(), 1u) << "the block that rots";
  }
}

TEST(TakeOver, APowerCutWhileTheCommitEventIsSaidAgainTakesNothing) {
  for (std::int64_t k = 1;; ++k) {
    SimulatedDisk disk(static_cast<std::uint64_t>(k));
    const auto promised = rot_and_tear(disk);
    if (!power_goes_at_call(disk, k, 30)) return;
    // More may be there, of the tail that is not cut yet.
    const FoundBlocks found = find_blocks(kFolder, disk);
    ASSERT_TRUE(std::ranges::includes(found.sequences, promised)) << "call " << k;
    ASSERT_EQ(found.false_blocks, 0) << "call " << k;
  }
}

// Its node has let go of it: asked to begin again before the hole, it would declare lost what lies behind.
TEST(TakeOver, WhatLiesBehindABlockThatRotsIsHeldAllTheSame) {
  SimulatedDisk disk;
  {
    Feeder feeder({.folder = kFolder}, disk);
    EXPECT_TRUE(feeder.append_through(20) && feeder.sync() && feeder.append_through(30) && feeder.sync());
  }
  disk.kill();
  SealedBlock block;
  damage_event(disk, 0, [&](const LogEvent& event) {
    return accept(event, block) == Refusal::kNone && block.header.sequence == 15;
  });
  Feeder feeder({.folder = kFolder}, disk);
  EXPECT_EQ(feeder.found(), 30);
  EXPECT_TRUE(feeder.append_through(40) && feeder.close());
  std::vector<std::int64_t> left = all_through(40);
  std::erase(left, 15);
  EXPECT_EQ(find_blocks(kFolder, disk).sequences, left);
}

TEST(ReadState, CountsNothingThatAPowerCutMayTakeAndGivesItApart) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SimulatedDisk disk(seed);
    ASSERT_NO_FATAL_FAILURE(fail_and_be_killed(disk));
    disk.set_read_only(true);
    std::vector<UnsureBlock> unsure;
    const RecordState state = read_state(kFolder, disk, {}, &unsure);
    ASSERT_EQ(state.epoch.size(), 1u);
    const std::int64_t counted = state.epoch.begin()->second.position.contiguous;
    EXPECT_EQ(counted, kPromised);
    ASSERT_EQ(std::ssize(unsure), kWritten - counted);
    for (std::size_t i = 0; i < unsure.size(); ++i)
      EXPECT_EQ(unsure[i].block.header.sequence, counted + 1 + static_cast<std::int64_t>(i));
    EXPECT_EQ(unsure.back().timestamp_us, 1000 * (kWritten - 1)) << "as it was recorded";
    disk.set_read_only(false);
    EXPECT_GE(std::ssize(left_by_power_cut(disk)), counted) << "seed " << seed;
  }
}

// Its commit event would have come with the next append.
TEST(ReadState, GivesApartWhatMayHaveBeenPromisedWithoutACommitEvent) {
  SimulatedDisk disk;
  Feeder feeder({.folder = kFolder}, disk);
  ASSERT_TRUE(feeder.append_through(kPromised) && feeder.sync());
  disk.kill();
  std::vector<UnsureBlock> unsure;
  EXPECT_TRUE(read_state(kFolder, disk, {}, &unsure).epoch.empty());
  ASSERT_FALSE(unsure.empty());
  EXPECT_EQ(unsure.back().block.header.sequence, kPromised);
}

// They repeat what is durable: a recorder that goes on in another folder begins its segments with them.
TEST(ReadState, KnowsTheDescriptionsThatASegmentWithoutACommitEventBeginsWith) {
  SimulatedDisk disk;
  RecordWriter writer({.folder = kFolder}, disk);
  writer.set_preamble([](const RecordState&) {
    SealedBlock vehicle;
    seal(MetaBlock{.header = {.node = 1, .epoch = 7}, .parts = 1, .text = "[vehicle]"}, vehicle);
    const auto bytes = vehicle.bytes();
    return RecordEvents{{block_channel(1, BlockKind::kMeta), {bytes.begin(), bytes.end()}}};
  });
  writer.append(numbered_block(1), 0);
  writer.sync();
  disk.kill();
  std::vector<UnsureBlock> unsure;
  const RecordState state = read_state(kFolder, disk, {}, &unsure);
  ASSERT_EQ(unsure.size(), 1u);
  EXPECT_EQ(state.vehicle.size(), 1u);
}

// The fallback's segments begin with all there is: the fit that the earlier record ended with would make a
// hole of the time since.
TEST(TakeOver, InAFolderThatContinuesAnotherTheClocksAreThoseOfItsLastSegment) {
  SimulatedDisk disk;
  const auto append_fit = [](RecordWriter& writer, std::int64_t s) {
    const ClockFit fit{.node = 1,
                       .epoch = 7,
                       .number = s,
                       .state = ClockState::kLocked,
                       .host_ns = s * 1'000'000'000,
                       .node_ns = s * 1'000'000'000};
    writer.append(clock_fit_channel(1), encode(fit), 0);
    return fit;
  };
  {
    RecordWriter writer({.folder = "/first"}, disk);
    append_fit(writer, 100);
    writer.close();
  }
  const RecordState before = read_state("/first", disk);
  ClockFit last_two[2];
  {
    RecordWriter writer({.folder = kFolder, .segment_bytes = 64 << 10}, disk, before);
    for (std::int64_t s = 101; writer.segment() < 3; ++s) {
      last_two[0] = std::exchange(last_two[1], append_fit(writer, s));
      for (int k = 0; k < 20; ++k) writer.append("RB_OTHER", std::vector<std::uint8_t>(1000), 0);
    }
    writer.sync();
    disk.kill();
  }
  const RecordWriter again({.folder = kFolder}, disk, before);
  const RecordState held_again = read_state(kFolder, disk, before);
  for (const RecordState* holds : {&again.holds(), &held_again}) {
    const RecordEvents events = clocks_going_on(*holds);
    ASSERT_EQ(events.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(decode_clock_fit(events[k].second), last_two[k]) << k;
  }
}

}  // namespace
}  // namespace roadbalance::test
