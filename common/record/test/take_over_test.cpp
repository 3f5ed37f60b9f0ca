#include "common/record/take_over.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/folder.hpp"
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

// A sync fails, and the recorder is killed before it could say in the next segment where this one ends.
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
    disk.set_fault(SimulatedDisk::at_call(disk.calls() + k, {.power_cut = true}));
    bool taken = false;
    try {
      const Feeder feeder({.folder = kFolder}, disk);
      taken = !disk.is_off();
    } catch (const std::system_error&) {
    }
    if (taken) {
      EXPECT_GT(k, 10) << "a take-over has more calls than that";
      return;
    }
    disk.set_fault(nullptr);
    disk.power_on();
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

// They repeat what is durable: whoever goes on in another folder begins its segments with them.
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

}  // namespace
}  // namespace roadbalance::test
