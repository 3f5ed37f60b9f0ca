// A spool whose disk does not give back what is in it.
#include <gtest/gtest.h>

#include <cerrno>
#include <optional>

#include "common/record/segment.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "firmware/spool_folder.hpp"
#include "firmware/test/spooled_blocks.hpp"

namespace roadbalance {
namespace {

using test::DiskCall;
using test::SimulatedDisk;
constexpr const char* kFolder = "/spool";

struct SpoolGivenUpTest : testing::Test {
  std::optional<DiskCall> failing;  // before the spool, whose end closes what is open
  SimulatedDisk disk;
  Ring ring{1600 * sizeof(SealedBlock)};
  SpoolFolder spool{{.folder = kFolder, .bytes = 4 << 20, .node = test::kNode, .epoch = test::kEpoch}, disk};
};

// For rb recover --spool: a disk that cannot be read now may be later, or elsewhere.
TEST_F(SpoolGivenUpTest, WhatAGivenUpBlockIsInStays) {
  for (int k = 0; k < 1500; ++k) test::seal_next(ring);
  spool.keep(ring, 1, 1500, WallTime(std::chrono::hours(1)));
  ASSERT_EQ(spool.next(), 1501);
  ASSERT_GT(segment_numbers(kFolder, disk).size(), 2u);
  spool.give_up_through(1);
  EXPECT_EQ(spool.base(), 2);
  spool.free_through(1500);
  EXPECT_EQ(segment_numbers(kFolder, disk), std::vector<int>{1}) << "the others are gone";
}

TEST_F(SpoolGivenUpTest, AnswersOnlyWhatKeepsSomething) {
  disk.set_fault([this](DiskCall call, std::int64_t, const std::string&) -> SimulatedDisk::Outcome {
    return {.error = call == failing ? EIO : 0};
  });
  for (const DiskCall call : {DiskCall::kOpen, DiskCall::kWrite, DiskCall::kSyncData}) {
    failing = call;
    EXPECT_FALSE(spool.answers());
    failing.reset();
    EXPECT_TRUE(spool.answers());
  }
}

}  // namespace
}  // namespace roadbalance
