#include <gtest/gtest.h>

#include <cerrno>
#include <stdexcept>

#include "common/record/folder.hpp"
#include "host/recorder/test/store_drive.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using test::DiskCall;
using test::kFolder;
using test::Outcome;

constexpr const char* kFallback = "/other";

class StoreFoldersTest : public ::testing::Test, protected test::Drive {
 protected:
  void fail_writes_below(std::string folder) {
    disk.set_fault([folder](DiskCall call, std::int64_t, const std::string& path) {
      const bool changes = call == DiskCall::kSyncData || call == DiskCall::kSync || call == DiskCall::kWrite;
      return Outcome{.error = changes && path.starts_with(folder) ? EIO : 0};
    });
  }
  /// A finished drive of 50 blocks, of which the last 30 went to the fallback; its first folder still fails.
  void drive_into_the_fallback() {
    options.fallback = kFallback;
    start();
    run(milliseconds(1000), 20);
    fail_writes_below(kFolder);
    run(milliseconds(3000), 30);
    store->close(now);
    store.reset();
  }
};

TEST_F(StoreFoldersTest, ARecordThatGoesOnInTheFallbackIsNotGoneOnWithWithoutIt) {
  drive_into_the_fallback();
  fail_nothing();
  start();  // the disk can be written again: it gets the name of the folder where the record goes on
  store.reset();

  options.fallback.clear();
  try {
    start();
    FAIL() << "what is in the fallback would be declared lost";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(kFallback), std::string::npos) << error.what();
  }
  options.fallback = "/third";
  EXPECT_THROW(start(), std::runtime_error);
  options.fallback = kFallback;
  start();
  EXPECT_EQ(store->recovered().epoch.begin()->second.position.contiguous, 50);
}

// A service's file does so each day: another folder for the record, the same for the fallback.
TEST_F(StoreFoldersTest, TheFallbackOfAnotherDriveIsRefusedAndLeftAlone) {
  drive_into_the_fallback();
  fail_nothing();
  const auto held = recorded(kFallback);
  options.folder = "/next drive";
  try {
    start();
    FAIL() << "the next drive would be swallowed by the fallback of the one before";
  } catch (const std::invalid_argument& error) {
    const std::string words = error.what();
    EXPECT_NE(words.find(kFallback), std::string::npos) << words;
    EXPECT_NE(words.find(kFolder), std::string::npos) << words;
  }
  EXPECT_EQ(recorded(kFallback), held);
  EXPECT_FALSE(path_exists("/next drive/incarnation", disk)) << "nothing has begun there";
  options.fallback = "/empty";
  start();
  EXPECT_EQ(store->folder(), "/next drive");
}

// If the next drive cannot be written at all, measuring goes before order.
TEST_F(StoreFoldersTest, TheFallbackOfAnotherDriveIsTakenWithAWarningIfThereIsNothingElse) {
  drive_into_the_fallback();
  ASSERT_EQ(disk.mkdir("/next drive", 0755), 0);
  ASSERT_EQ(disk.mkdir("/third drive", 0755), 0);
  const auto expect_it_is_taken = [&](const char* drive) {
    options.folder = drive;
    start();
    EXPECT_EQ(store->folder(), kFallback);
    EXPECT_TRUE(was_warned_of("recording goes on in /other"));
    store.reset();
    fail_nothing();
    start();
    EXPECT_EQ(store->folder(), kFallback) << "that is where this drive is, too";
    store.reset();
  };
  fail_writes_below("/next drive");
  expect_it_is_taken("/next drive");
  fail({DiskCall::kWrite}, EROFS, "/third drive");  // mounted read-only: a sync succeeds
  expect_it_is_taken("/third drive");
}

// The name of the folder where the record goes on could never be written to the first one.
TEST_F(StoreFoldersTest, AFallbackKnowsByItselfWhatItContinues) {
  drive_into_the_fallback();
  fail_nothing();
  ASSERT_FALSE(path_exists("/record/continued-in", disk));
  start();
  EXPECT_EQ(store->folder(), kFallback);
  EXPECT_TRUE(was_warned_of("recording goes on in /other"));
}

TEST_F(StoreFoldersTest, AFallbackThatCannotBeUsedChangesNothing) {
  options.fallback = "/no/such/disk";
  start();
  run(milliseconds(1000), 20);
  disk.set_read_only(true);
  run(milliseconds(5000), 20);
  EXPECT_TRUE(was_warned_of("the fallback folder cannot be used"));
  EXPECT_EQ(store->state(), RecorderState::kDiskFailing);
  disk.set_read_only(false);
  run(milliseconds(2000), 20);
  note_durable(store->close(now));
  auto all = recorded();
  if (path_exists("/no/such/disk/seg-000001.lcm", disk))
    for (const std::int64_t sequence : recorded("/no/such/disk")) all.push_back(sequence);
  EXPECT_EQ(all, test::all_through(60));
}

// Its content is missing, and nothing else.
TEST_F(StoreFoldersTest, WhatIsWrittenToARemovedSegmentIsNeverCalledDurableButWrittenToTheNext) {
  start();
  run(milliseconds(1000), 20);
  ASSERT_EQ(disk.unlink("/record/seg-000001.lcm"), 0);
  run(milliseconds(3000), 30);
  EXPECT_EQ(durable, 50);
  EXPECT_EQ(store->state(), RecorderState::kRecording);
  EXPECT_TRUE(was_warned_of("not in its folder any more"));
  fail_syncs(EIO);
  run(milliseconds(2000), 0);
  store->append(Delivery(test::numbered_block(++given)), now);
  run(milliseconds(2000), 0);
  fail_nothing();
  run(milliseconds(2000), 0);
  EXPECT_TRUE(was_warned_of("nothing was lost")) << "told once";
  note_durable(store->close(now));
  auto expected = test::all_through(51);
  expected.erase(expected.begin(), expected.begin() + 20);
  EXPECT_EQ(recorded(), expected);
}

TEST_F(StoreFoldersTest, AMovedFolderAndItsCopyAreTold) {
  start();
  run(milliseconds(1000), 20);
  ASSERT_EQ(disk.rename("/record", "/moved"), 0);
  ASSERT_EQ(disk.mkdir("/record", 0755), 0);
  for (const std::string& name : list_folder("/moved", disk))
    disk.put("/record/" + name, disk.content("/moved/" + name));
  run(milliseconds(3000), 30);
  note_durable(store->close(now));
  EXPECT_EQ(durable, 50);
  EXPECT_EQ(recorded(), test::all_through(50));
}

// Credit is closed, so that no block comes that would show it.
TEST_F(StoreFoldersTest, ADiskThatWorksAgainIsNoticedWithoutAnyBlock) {
  start();
  run(milliseconds(1000), 20);
  fail_syncs(EIO);
  for (int k = 0; k < 2; ++k) {
    store->note(NoteKind::kClock, 0, 0, "");
    note_durable(store->commit(now += milliseconds(1100)));
  }
  run(milliseconds(5000));
  fail_nothing();
  run(milliseconds(5000));
  EXPECT_EQ(store->state(), RecorderState::kRecording);
  EXPECT_TRUE(store->wants_credit());
}

TEST_F(StoreFoldersTest, ARefusedSecondRecorderTakesNothingFromTheFirst) {
  start();
  run(milliseconds(1000), 20);
  ASSERT_TRUE(path_exists("/record/ballast", disk));
  EXPECT_THROW(RecordingStore(disk, options), std::runtime_error);
  EXPECT_TRUE(path_exists("/record/ballast", disk));
}

TEST_F(StoreFoldersTest, SaysHowManyMeasurementsOfClocksItCouldNotKeep) {
  start();
  run(milliseconds(1000), 20);
  fail_syncs(EIO);
  run(milliseconds(2000), 20);
  const RecordEvent event{.channel = "RB_CLOCK", .bytes = std::vector<std::uint8_t>(1000)};
  for (int k = 0; k < 20'000; ++k) store->append(event, now);
  fail_nothing();
  run(milliseconds(3000));
  EXPECT_TRUE(was_warned_of("measurements of the nodes' clocks were not kept"));
  EXPECT_EQ(durable, 40);
}

// A step of a day either way, twice a second: the record differs in its table of clocks and nowhere else.
TEST_F(StoreFoldersTest, AStepOfTheWallClockChangesNothingButTheTable) {
  constexpr std::int64_t kDay_us = 86'400'000'000;
  test::Drive other;
  start();
  other.start();
  for (int k = 1; k <= 100; ++k) {
    const std::int64_t utc_us = 1'790'000'000'000'000 + k * 500'000;
    store->set_clocks(utc_us, k);
    other.store->set_clocks(utc_us + (k % 3 - 1) * kDay_us, k);
    run(milliseconds(500), 20);
    other.run(milliseconds(500), 20);
    ASSERT_EQ(other.durable, durable);
    ASSERT_EQ(other.store->state(), RecorderState::kRecording);
  }
  note_durable(store->close(now));
  other.note_durable(other.store->close(other.now));
  EXPECT_EQ(recorded(), test::all_through(2000));
  EXPECT_EQ(other.recorded(), test::all_through(2000));
  RecorderStatus status, other_status;
  store->fill(status);
  other.store->fill(other_status);
  EXPECT_EQ(other_status.segment, status.segment);
  EXPECT_EQ(other_status.bytes_recorded, status.bytes_recorded);
  const auto table = notes(NoteKind::kClock), stepped = other.notes(NoteKind::kClock);
  ASSERT_EQ(stepped.size(), table.size());
  bool differs = false;
  for (std::size_t k = 0; k < table.size(); ++k) {
    EXPECT_EQ(stepped[k].host_ns, table[k].host_ns);
    differs = differs || stepped[k].time_us != table[k].time_us;
  }
  EXPECT_TRUE(differs);
}

}  // namespace
}  // namespace roadbalance
