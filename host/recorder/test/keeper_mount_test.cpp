#include <gtest/gtest.h>

#include <cerrno>

#include "common/record/folder.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recorder/test/keeper_drive.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using test::kFolder;

constexpr const char* kFallback = "/other";

/// The folder is where a disk is mounted.
class KeeperMountTest : public ::testing::Test, protected test::Drive {
 protected:
  void SetUp() override {
    ASSERT_EQ(disk.mkdir(kFolder, 0755), 0);
    disk.mount(kFolder);
    ASSERT_EQ(next_incarnation(kFolder, 1, disk), 1);
    start();
    run(milliseconds(1000), 20);
  }
  void expect_that_it_waits_and_writes_nothing() {
    const std::int64_t before = durable;
    const auto beneath = disk.list(kFolder);
    run(milliseconds(5000), 30);
    EXPECT_EQ(durable, before);
    EXPECT_EQ(keeper->state(), RecorderState::kDiskFailing);
    EXPECT_EQ(keeper->failure().value_or("").find("recording /record (mount the disk again that it began on"),
              0u);
    EXPECT_EQ(disk.list(kFolder), beneath);
  }
  void expect_that_it_goes_on() {
    run(milliseconds(3000), 20);
    EXPECT_EQ(keeper->state(), RecorderState::kRecording);
    EXPECT_TRUE(was_warned_of("nothing was lost"));
    note_durable(keeper->close(now));
    EXPECT_EQ(recorded(), test::all_through(given));
  }
};

TEST_F(KeeperMountTest, ADiskThatFailsAndIsUnmountedIsWaitedFor) {
  fail_syncs(EIO);
  run(milliseconds(3000), 20);
  disk.unmount(kFolder);
  fail_nothing();
  expect_that_it_waits_and_writes_nothing();
  disk.mount(kFolder);
  expect_that_it_goes_on();
}

TEST_F(KeeperMountTest, ADiskThatIsUnmountedWhileItIsWrittenIsWaitedFor) {
  disk.unmount(kFolder);
  expect_that_it_waits_and_writes_nothing();
  disk.mount(kFolder);
  expect_that_it_goes_on();
}

TEST_F(KeeperMountTest, ADiskThatIsUnmountedWhileNothingComesIsWaitedFor) {
  note_durable(keeper->seal(now));
  disk.unmount(kFolder);
  expect_that_it_waits_and_writes_nothing();
  disk.mount(kFolder);
  expect_that_it_goes_on();
}

TEST_F(KeeperMountTest, AnotherRecordingsDiskIsLeftAlone) {
  disk.unmount(kFolder);
  disk.put("/record/incarnation", {'?'});
  expect_that_it_waits_and_writes_nothing();
}

TEST_F(KeeperMountTest, TheFallbackTakesOverFromADiskThatIsUnmounted) {
  keeper.reset();
  options.fallback = kFallback;
  start();
  run(milliseconds(1000), 20);
  disk.unmount(kFolder);
  run(milliseconds(5000), 30);
  note_durable(keeper->close(now));
  EXPECT_EQ(durable, 70);
  EXPECT_FALSE(path_exists("/record/seg-000001.lcm", disk));
  disk.mount(kFolder);
  auto all = recorded();
  for (const std::int64_t sequence : recorded(kFallback))
    if (sequence > all.back()) all.push_back(sequence);
  EXPECT_EQ(all, test::all_through(70));
}

}  // namespace
}  // namespace roadbalance
