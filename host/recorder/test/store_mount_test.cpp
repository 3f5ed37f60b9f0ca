#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/record/folder.hpp"
#include "common/test/temporary_directory.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recorder/test/store_drive.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

constexpr const char* kDisk = "/disk";
constexpr const char* kRecord = "/disk/record";
constexpr const char* kFallback = "/other";
constexpr std::int64_t kIncarnation = 7;

enum class Way {
  kUnmounted,  ///< and mounted again
  kPluggedIn,  ///< anew, when it comes back: what is open of the disk that was, works on
  kPulledOut,  ///< and plugged in anew: what was open fails
};

struct Case {
  std::string_view mount_point;
  Way way;
};

/// The record is on a disk that is mounted at its folder, or above it as in recordings/NAME.
class StoreMountTest : public ::testing::TestWithParam<Case>, protected test::Drive {
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
    store.reset();
    options.least_incarnation = kIncarnation;
    start();
  }
  void unmount() {
    const std::string folder(GetParam().mount_point);
    GetParam().way == Way::kPulledOut ? disk.pull_out(folder) : disk.unmount(folder);
  }
  void mount() {
    const std::string folder(GetParam().mount_point);
    GetParam().way == Way::kUnmounted ? disk.mount(folder) : disk.plug_in(folder);
  }
  /// More than a segment takes.
  void expect_that_it_waits_and_writes_nothing() {
    const std::int64_t before = durable;
    const auto beneath = disk.list(kRecord);
    run(milliseconds(5000), 100);
    EXPECT_EQ(durable, before);
    EXPECT_EQ(store->state(), RecorderState::kDiskFailing);
    EXPECT_EQ(store->failure().value_or("").find("recording /disk/record (mount "), 0u)
        << store->failure().value_or("");
    EXPECT_EQ(disk.list(kRecord), beneath);
  }
  void expect_that_it_goes_on() {
    run(milliseconds(3000), 20);
    EXPECT_EQ(store->state(), RecorderState::kRecording);
    EXPECT_TRUE(was_warned_of("nothing was lost"));
    note_durable(store->close(now));
    EXPECT_EQ(recorded(kRecord), test::all_through(given));
  }
};

TEST_P(StoreMountTest, ADiskThatFailsAndIsUnmountedIsWaitedFor) {
  fail_syncs(EIO);
  run(milliseconds(3000), 20);
  unmount();
  fail_nothing();
  expect_that_it_waits_and_writes_nothing();
  mount();
  expect_that_it_goes_on();
}

TEST_P(StoreMountTest, ADiskThatIsUnmountedWhileItIsWrittenIsWaitedFor) {
  unmount();
  expect_that_it_waits_and_writes_nothing();
  mount();
  expect_that_it_goes_on();
}

TEST_P(StoreMountTest, ADiskThatIsUnmountedWhileNothingComesIsWaitedFor) {
  note_durable(store->seal(now));
  unmount();
  expect_that_it_waits_and_writes_nothing();
  mount();
  expect_that_it_goes_on();
}

TEST_P(StoreMountTest, ADiskWhoseIncarnationWasRaisedIsKnown) {
  ASSERT_EQ(raise_incarnation(kRecord, kIncarnation + 5, disk), kIncarnation + 6);
  unmount();
  EXPECT_THROW((void)raise_incarnation(kRecord, kIncarnation + 9, disk), std::system_error);
  expect_that_it_waits_and_writes_nothing();
  mount();
  expect_that_it_goes_on();
}

TEST_P(StoreMountTest, AnotherRecordingIsLeftAlone) {
  unmount();
  if (GetParam().mount_point == kDisk) {
    ASSERT_EQ(disk.mkdir(kRecord, 0755), 0);
  }
  disk.put("/disk/record/incarnation", {'0' + kIncarnation - 1, '\n'});
  expect_that_it_waits_and_writes_nothing();
  disk.put("/disk/record/incarnation", {'?'});
  expect_that_it_waits_and_writes_nothing();
  disk.put("/disk/record/incarnation", {'0' + kIncarnation + 1, '\n'});
  disk.put("/disk/record/seg-000001.lcm", {1, 2, 3});
  expect_that_it_waits_and_writes_nothing();
}

// A copy of the disk in its place lacks what came since it was made.
TEST_P(StoreMountTest, AnEarlierCopyIsLeftAlone) {
  std::map<std::string, std::vector<std::uint8_t>> copy;
  for (const std::string& name : list_folder(kRecord, disk))
    copy[name] = disk.content("/disk/record/" + name);
  run(milliseconds(1000), 20);
  unmount();
  if (GetParam().mount_point == kDisk) {
    ASSERT_EQ(disk.mkdir(kRecord, 0755), 0);
  }
  for (const auto& [name, bytes] : copy) disk.put("/disk/record/" + name, bytes);
  expect_that_it_waits_and_writes_nothing();
  mount();
  expect_that_it_goes_on();
}

// Nothing is open of ours, so that the kernel may give its number to another.
TEST_P(StoreMountTest, AnotherDiskOfTheSameNumberIsLeftAlone) {
  const FileIdentity own = disk.identity(kRecord).value_or(FileIdentity{});
  unmount();
  run(milliseconds(2000), 10);
  disk.replace(std::string(GetParam().mount_point));
  if (GetParam().mount_point == kDisk) {
    ASSERT_EQ(disk.mkdir(kRecord, 0755), 0);
  }
  ASSERT_EQ(disk.identity(kRecord).value_or(FileIdentity{}).device, own.device);
  expect_that_it_waits_and_writes_nothing();
}

TEST_P(StoreMountTest, TheFallbackTakesOverFromADiskThatIsUnmounted) {
  options.fallback = kFallback;
  begin();
  run(milliseconds(1000), 20);
  unmount();
  const auto beneath = disk.list(kRecord);
  run(milliseconds(5000), 30);
  note_durable(store->close(now));
  EXPECT_FALSE(was_warned_of("not in its folder any more"));
  EXPECT_EQ(durable, 70);
  EXPECT_EQ(disk.list(kRecord), beneath);
  mount();
  auto all = recorded(kRecord);
  for (const std::int64_t sequence : recorded(kFallback))
    if (sequence > all.back()) all.push_back(sequence);
  EXPECT_EQ(all, test::all_through(70));
}

TEST_P(StoreMountTest, TheRoomBeneathIsNotTheDisks) {
  note_durable(store->seal(now));
  unmount();
  disk.set_capacity(disk.used_bytes());
  run(milliseconds(60'000));
  EXPECT_EQ(store->state(), RecorderState::kRecording);
  EXPECT_FALSE(was_warned_of("disk"));
}

// As when it was stopped while its disk was away, and its recorder ended: what is beneath is another disk.
TEST_P(StoreMountTest, ARecordingThatIsKnownIsNotBegunWhereItIsNot) {
  store.reset();
  unmount();
  const auto beneath = disk.list(kRecord);
  options.continues = true;
  EXPECT_THROW(start(), std::system_error);
  EXPECT_EQ(disk.list(kRecord), beneath);
  options.fallback = kFallback;
  start();
  EXPECT_EQ(store->folder(), kFallback);
  EXPECT_EQ(disk.list(kRecord), beneath);
  store.reset();
  options.fallback.clear();
  mount();
  begin();
  run(milliseconds(1000), 20);
  note_durable(store->close(now));
  EXPECT_EQ(recorded(kRecord), test::all_through(given));
}

INSTANTIATE_TEST_SUITE_P(Everywhere, StoreMountTest,
                         ::testing::Values(Case{kRecord, Way::kUnmounted}, Case{kRecord, Way::kPluggedIn},
                                           Case{kRecord, Way::kPulledOut}, Case{kDisk, Way::kUnmounted},
                                           Case{kDisk, Way::kPluggedIn}, Case{kDisk, Way::kPulledOut}));

// No disk was behind it: what was in it is lost, the rest is recorded, and the folder is the recording's
// again.
TEST(StoreFolder, ThatIsMadeAgainIsGoneOnWith) {
  const test::TemporaryDirectory work;
  const auto folder = work / "record";
  RecordingStore store(kernel_disk(), {.folder = folder, .least_incarnation = kIncarnation});
  store.set_clocks(1, 1);
  store.begin();
  WallTime now{std::chrono::hours(1)};
  std::int64_t durable = 0;
  const auto run = [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t sequence = first; sequence <= last; ++sequence)
      store.append(Delivery(test::numbered_block(sequence)), now += milliseconds(100));
    for (int k = 0; k < 30; ++k)
      for (const DurableMark& mark : store.commit(now += milliseconds(100))) durable = mark.sequence;
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
  EXPECT_EQ(store.state(), RecorderState::kRecording);
  EXPECT_EQ(stored_incarnation(folder), kIncarnation);
}

}  // namespace
}  // namespace roadbalance
