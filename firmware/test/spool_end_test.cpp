#include <gtest/gtest.h>

#include <cerrno>

#include "common/link/backlog.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "firmware/spool_folder.hpp"
#include "firmware/test/spooled_blocks.hpp"

namespace roadbalance {
namespace {

using test::DiskCall;
using test::seal_next;
using test::SimulatedDisk;

struct SpoolEndTest : testing::Test {
  const WallTime now{std::chrono::hours(1)};
  const SpoolFolder::Options options{
      .folder = "/spool", .bytes = 4 << 20, .node = test::kNode, .epoch = test::kEpoch};
  SimulatedDisk disk;
  Ring ring{160 * sizeof(SealedBlock)};
};

// The program ends within the second that a failure makes the spool wait.
TEST_F(SpoolEndTest, TheEndWaitsForNoFailureBefore) {
  SpoolFolder spool(options, disk);
  Backlog backlog(ring, &spool);
  disk.set_fault([](DiskCall call, std::int64_t, const std::string&) {
    return SimulatedDisk::Outcome{.error = call == DiskCall::kSyncData ? EIO : 0};
  });
  while (ring.next() <= 100) seal_next(ring);
  backlog.relieve(now);
  ASSERT_GT(backlog.spool_failures(), 0);
  ASSERT_EQ(backlog.spooled(), 0);
  disk.set_fault({});
  backlog.save(now);
  EXPECT_EQ(backlog.spooled(), 100);
}

TEST_F(SpoolEndTest, TheEndGoesOnInANewSegmentWhateverCallFails) {
  const auto save = [this](const SimulatedDisk::Fault& fault, std::int64_t& calls) {
    SimulatedDisk other;
    Ring large(3000 * sizeof(SealedBlock));
    SpoolFolder spool(options, other);
    Backlog backlog(large, &spool);
    while (large.next() <= 1000) seal_next(large);
    const std::int64_t before = other.calls();
    other.set_fault([&](DiskCall call, std::int64_t number, const std::string& path) {
      return fault(call, number - before, path);
    });
    backlog.save(now);
    calls = other.calls() - before;
    return backlog.spooled();
  };
  std::int64_t calls = 0, ignored = 0;
  ASSERT_EQ(save([](auto, auto, auto) { return SimulatedDisk::Outcome{}; }, calls), 1000);
  ASSERT_GT(calls, 10);
  for (const int error : {EIO, ENOSPC})
    for (std::int64_t k = 1; k <= calls; ++k)
      EXPECT_EQ(save(SimulatedDisk::at_call(k, {.error = error}), ignored), 1000) << k;
  EXPECT_EQ(save([](auto, auto, auto) { return SimulatedDisk::Outcome{.error = EIO}; }, ignored), 0)
      << "and comes to an end";
  EXPECT_LT(ignored, 100);
}

TEST_F(SpoolEndTest, TheEndTriesAFewTimesWhatADiskRefuses) {
  SpoolFolder spool(options, disk);
  Backlog backlog(ring, &spool);
  while (ring.next() <= 100) seal_next(ring);
  int refusals = 4;
  disk.set_fault([&refusals](DiskCall call, std::int64_t, const std::string&) {
    return SimulatedDisk::Outcome{.error = call == DiskCall::kWrite && refusals-- > 0 ? EIO : 0};
  });
  backlog.save(now);
  EXPECT_EQ(backlog.spooled(), 100);
}

}  // namespace
}  // namespace roadbalance
