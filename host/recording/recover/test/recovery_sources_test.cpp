// Sources that cannot be read, or not the same each time.
#include "host/recording/recover/recovery_sources.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/record/segment.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "host/recording/manifest.hpp"
#include "host/recording/recover/recover.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

using test::DiskCall;
using Outcome = test::SimulatedDisk::Outcome;

class RecoverySourcesTest : public ::testing::Test {
 protected:
  void record(std::int64_t last) {
    test::Feeder feeder({.folder = "/old", .segment_bytes = 64 << 10}, disk);
    ASSERT_TRUE(feeder.append_through(last));
    ASSERT_TRUE(feeder.close());
  }

  test::SimulatedDisk disk;
};

TEST_F(RecoverySourcesTest, ASectorThatCannotBeReadTakesNoMoreThanItsPage) {
  record(100);
  const std::string index = "/old/seg-000001.idx", segment = "/old/seg-000001.lcm";
  write_manifest("/old", std::nullopt, disk);
  disk.spoil(segment, 20'000);
  disk.spoil(index, 0);
  disk.spoil("/old/manifest.json", 0);
  const Verification before = verify_record("/old", disk);
  EXPECT_EQ(before.verdict, Verdict::kDamaged) << before.error;
  EXPECT_EQ(std::ranges::count(before.damage,
                               "seg-000001.lcm: 4096 bytes from 16384 on cannot be read: Input/output error"),
            1);
  EXPECT_EQ(std::ranges::count(before.indexes, "manifest.json: is damaged"), 1);
  EXPECT_TRUE(before.indexes.front().starts_with("seg-000001.idx: is damaged")) << before.indexes.front();

  const Recovered recovered = recover({"/old"}, "/new", disk);
  EXPECT_EQ(std::ranges::count(recovered.damage,
                               segment + ": 4096 bytes from 16384 on cannot be read: Input/output "
                                         "error"),
            1);
  // A block takes some 1.4 kB, fewer than a third of them much less.
  EXPECT_GE(recovered.blocks, 88);
  EXPECT_LT(recovered.blocks, 100);
  EXPECT_EQ(recovered.lost.size(), 1u);
  const Verification made = verify_record("/new", disk);
  for (const auto& line : made.damage) ADD_FAILURE() << line;
  for (const auto& epoch : made.epoch)
    for (const auto& line : epoch.contradictions) ADD_FAILURE() << line;
}

// A lock keeps a recorder away, but no program that copies something there.
TEST_F(RecoverySourcesTest, AnEpochThatComesWhileTheyAreReadIsSaidToBeAChange) {
  record(10);
  SealedBlock other;
  seal(EndBlock{.header = {.node = 9, .epoch = 5, .sequence = 1}, .blocks = 1}, other);
  RecordWriter second({.folder = "/second"}, disk);
  second.append(other, 0);
  second.close();
  const auto bytes = disk.content("/second/seg-000001.lcm");
  bool came = false;
  disk.set_fault([&](DiskCall call, std::int64_t, const std::string& path) {
    if (call == DiskCall::kMakeFolder && path == "/new" && !came) {
      came = true;
      auto longer = disk.content("/old/seg-000001.lcm");
      longer.insert(longer.end(), bytes.begin(), bytes.end());
      disk.put("/old/seg-000001.lcm", longer);
    }
    return Outcome{};
  });
  try {
    recover({"/old"}, "/new", disk);
    FAIL() << "nothing of that epoch was planned";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "/old/seg-000001.lcm: changed while it was read");
  }
}

}  // namespace
}  // namespace roadbalance
