// Sources that do not give what they hold, or not the same each time.
#include "tools/rb/salvage_sources.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "common/record/segment.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "tools/rb/salvage.hpp"

namespace roadbalance {
namespace {

using test::DiskCall;
using Outcome = test::SimulatedDisk::Outcome;

class SalvageSourcesTest : public ::testing::Test {
 protected:
  void record(std::int64_t last) {
    test::Feeder feeder({.folder = "/old", .segment_bytes = 64 << 10}, disk);
    ASSERT_TRUE(feeder.append_through(last));
    ASSERT_TRUE(feeder.close());
  }

  test::SimulatedDisk disk;
};

// A lock keeps a recorder away, but not whoever copies something there.
TEST_F(SalvageSourcesTest, AnEpochThatComesWhileTheyAreReadIsSaidToBeAChange) {
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
    salvage({"/old"}, "/new", disk);
    FAIL() << "nothing of that epoch was planned";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "/old/seg-000001.lcm: changed while it was read");
  }
}

}  // namespace
}  // namespace roadbalance
