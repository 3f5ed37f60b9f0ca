#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/test/temporary_directory.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recorder/test/keeper_drive.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

constexpr const char* kDisk = "/disk";
constexpr const char* kRecord = "/disk/record";
constexpr const char* kFallback = "/other";
constexpr std::int64_t kIncarnation = 7;

struct Case {
  std::string_view mount_point;
  bool plugged_in;  ///< anew, when it comes back
};

/// The record is on a disk that is mounted at its folder, or above it as in recordings/NAME.
class KeeperMountTest : public ::testing::TestWithParam<Case>, protected test::Drive {
 protected:
  void SetUp() override {
    ASSERT_EQ(disk.mkdir(kDisk, 0755), 0);
    if (GetParam().mount_point == kRecord) {
      ASSERT_EQ(disk.mkdir(kRecord, 0755), 0);
    }
    disk.mount(std::string(GetParam().mount_point));
    options.folder = kRecord;
    begin();
    run(milliseconds(1000), 20);
  }
  void begin() {
    keeper.reset();
    start();
    ASSERT_LE(next_incarnation(kRecord, kIncarnation, disk), kIncarnation + 1);
    keeper->begin(kIncarnation);
  }
  void unmount() { disk.unmount(std::string(GetParam().mount_point)); }
  void mount() { disk.mount(std::string(GetParam().mount_point), GetParam().plugged_in); }
  /// More than a segment takes.
  void expect_that_it_waits_and_writes_nothing() {
    const std::int64_t before = durable;
    const auto beneath = disk.list(kRecord);
    run(milliseconds(5000), 100);
    EXPECT_EQ(durable, before);
    EXPECT_EQ(keeper->state(), RecorderState::kDiskFailing);
    EXPECT_EQ(keeper->failure().value_or("").find("recording /disk/record (mount "), 0u)
        << keeper->failure().value_or("");
    EXPECT_EQ(disk.list(kRecord), beneath);
  }
  void expect_that_it_goes_on() {
    run(milliseconds(3000), 20);
    EXPECT_EQ(keeper->state(), RecorderState::kRecording);
    EXPECT_TRUE(was_warned_of("nothing was lost"));
    note_durable(keeper->close(now));
    EXPECT_EQ(recorded(kRecord), test::all_through(given));
  }
};

TEST_P(KeeperMountTest, ADiskThatFailsAndIsUnmountedIsWaitedFor) {
  fail_syncs(EIO);
  run(milliseconds(3000), 20);
  unmount();
  fail_nothing();
  expect_that_it_waits_and_writes_nothing();
  mount();
  expect_that_it_goes_on();
}

TEST_P(KeeperMountTest, ADiskThatIsUnmountedWhileItIsWrittenIsWaitedFor) {
  unmount();
  expect_that_it_waits_and_writes_nothing();
  mount();
  expect_that_it_goes_on();
}

TEST_P(KeeperMountTest, ADiskThatIsUnmountedWhileNothingComesIsWaitedFor) {
  note_durable(keeper->seal(now));
  unmount();
  expect_that_it_waits_and_writes_nothing();
  mount();
  expect_that_it_goes_on();
}

TEST_P(KeeperMountTest, ADiskWhoseIncarnationWasRaisedIsKnown) {
  ASSERT_EQ(raise_incarnation(kRecord, kIncarnation + 5, disk), kIncarnation + 6);
  unmount();
  EXPECT_THROW((void)raise_incarnation(kRecord, kIncarnation + 9, disk), std::system_error);
  expect_that_it_waits_and_writes_nothing();
  mount();
  expect_that_it_goes_on();
}

TEST_P(KeeperMountTest, AnotherRecordingIsLeftAlone) {
  unmount();
  if (GetParam().mount_point == kDisk) {
    ASSERT_EQ(disk.mkdir(kRecord, 0755), 0);
  }
  disk.put("/disk/record/incarnation", {'0' + kIncarnation - 1, '\n'});
  expect_that_it_waits_and_writes_nothing();
  disk.put("/disk/record/incarnation", {'?'});
  expect_that_it_waits_and_writes_nothing();
}

TEST_P(KeeperMountTest, TheFallbackTakesOverFromADiskThatIsUnmounted) {
  options.fallback = kFallback;
  begin();
  run(milliseconds(1000), 20);
  unmount();
  const auto beneath = disk.list(kRecord);
  run(milliseconds(5000), 30);
  note_durable(keeper->close(now));
  EXPECT_EQ(durable, 70);
  EXPECT_EQ(disk.list(kRecord), beneath);
  mount();
  auto all = recorded(kRecord);
  for (const std::int64_t sequence : recorded(kFallback))
    if (sequence > all.back()) all.push_back(sequence);
  EXPECT_EQ(all, test::all_through(70));
}

TEST_P(KeeperMountTest, TheRoomBeneathIsNotTheDisks) {
  note_durable(keeper->seal(now));
  unmount();
  const auto beneath = disk.list(kRecord);
  run(milliseconds(60'000));
  EXPECT_EQ(disk.list(kRecord), beneath);
}

INSTANTIATE_TEST_SUITE_P(Everywhere, KeeperMountTest,
                         ::testing::Values(Case{kRecord, false}, Case{kRecord, true}, Case{kDisk, false},
                                           Case{kDisk, true}));

// No disk was behind it: what was in it is lost, the rest is recorded, and the folder is the recording's
// again.
TEST(KeeperFolder, ThatIsMadeAgainIsGoneOnWith) {
  const test::TemporaryDirectory work;
  const auto folder = work / "record";
  RecordKeeper keeper(kernel_disk(), {.folder = folder});
  keeper.set_clocks(1, 1);
  keeper.begin(kIncarnation);
  WallTime now{std::chrono::hours(1)};
  std::int64_t durable = 0;
  const auto run = [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t sequence = first; sequence <= last; ++sequence)
      keeper.append(Delivery(test::numbered_block(sequence)), now += milliseconds(100));
    for (int k = 0; k < 30; ++k)
      for (const DurableMark& mark : keeper.commit(now += milliseconds(100))) durable = mark.sequence;
  };
  run(1, 20);
  ASSERT_EQ(durable, 20);
  std::filesystem::remove_all(folder);
  run(21, 30);
  EXPECT_EQ(durable, 20);
  EXPECT_FALSE(std::filesystem::exists(folder)) << "it may be where a disk was mounted";
  std::filesystem::create_directory(folder);
  run(31, 40);
  EXPECT_EQ(durable, 40);
  EXPECT_EQ(keeper.state(), RecorderState::kRecording);
  EXPECT_EQ(stored_incarnation(folder), kIncarnation);
}

}  // namespace
}  // namespace roadbalance
