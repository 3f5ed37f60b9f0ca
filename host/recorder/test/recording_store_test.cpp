#include "host/recorder/recording_store.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>

#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "host/recorder/test/store_drive.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using test::DiskCall;
using test::kFolder;
using test::Outcome;

constexpr const char* kFallback = "/other";

class RecordingStoreTest : public ::testing::Test, protected test::Drive {};

TEST_F(RecordingStoreTest, CommitsAsAGroupWhenTheFirstBlockIsOldEnough) {
  start();
  run(milliseconds(50), 5);
  EXPECT_EQ(durable, 0);
  run(milliseconds(200));
  EXPECT_EQ(durable, 5);
  EXPECT_EQ(recorded(), test::all_through(5));
}

TEST_F(RecordingStoreTest, CommitsTheFirstSamplesAtOnceWhereSomebodyWaitsForThem) {
  options.first_at_once = true;
  start();
  run(milliseconds(50), 5);
  EXPECT_EQ(durable, 1);
  run(milliseconds(200));
  EXPECT_EQ(durable, 5);
}

TEST_F(RecordingStoreTest, CommitsAtOnceWhenThereIsMuch) {
  options.commit_bytes = 20'000;
  start();
  run(milliseconds(10), 40);
  EXPECT_EQ(durable, 40);
}

TEST_F(RecordingStoreTest, NotesAloneBeginNoSegment) {
  start();
  run(milliseconds(5000));
  store->close(now);
  EXPECT_FALSE(path_exists("/record/seg-000001.lcm", disk));
}

// The supply is gone and the nodes with it: the note of that comes behind the last block.
TEST_F(RecordingStoreTest, WhatHappensBehindASealIsInTheRecord) {
  start();
  run(milliseconds(1000), 20);
  store->note(NoteKind::kPowerLost, 0, 0, "supply:AC");
  note_durable(store->seal(now));
  store->note(NoteKind::kAlarmBegan, 1, 1, "silent");
  run(milliseconds(1000));
  EXPECT_EQ(notes(NoteKind::kAlarmBegan).size(), 1u);
  note_durable(store->seal(now));
  store->close(now);
  EXPECT_EQ(notes(NoteKind::kStopped).size(), 1u);
}

TEST_F(RecordingStoreTest, ARestartOfWhichNoBlockComesIsInTheRecordOnceItSaysSomething) {
  start();
  run(milliseconds(1000), 20);
  store->close(now);
  for (int k = 0; k < 3; ++k) {  // it crashes again and again
    start();
    run(milliseconds(1000));
    disk.kill();
  }
  EXPECT_EQ(segment_numbers(kFolder, disk).size(), 1u);
  EXPECT_EQ(notes(NoteKind::kStarted).size(), 1u);
  start();
  store->close(now);
  EXPECT_EQ(notes(NoteKind::kStarted).size(), 2u);
  EXPECT_EQ(notes(NoteKind::kStopped).size(), 2u);
}

TEST_F(RecordingStoreTest, NotesThatADiskRefusesAtTheEndAreSaidToBeMissing) {
  start();
  run(milliseconds(1000), 20);
  note_durable(store->seal(now));
  fail({DiskCall::kWrite, DiskCall::kReserve}, EIO);
  store->close(now);
  EXPECT_TRUE(was_warned_of("the last notes are not on the disk: "));
}

// Within the second for which a failing disk is left alone.
TEST_F(RecordingStoreTest, TheEndTriesAFailingDiskAtOnce) {
  start();
  run(milliseconds(1000), 20);
  fail({DiskCall::kWrite, DiskCall::kReserve, DiskCall::kSyncData, DiskCall::kTruncate}, EIO);
  run(milliseconds(300), 4);
  ASSERT_EQ(store->state(), RecorderState::kDiskFailing);
  fail_nothing();
  note_durable(store->close(now));
  EXPECT_EQ(durable, given);
  EXPECT_EQ(recorded(), test::all_through(24));
  EXPECT_EQ(notes(NoteKind::kStopped).size(), 1u);
}

// A recorder that began anew while its recording was being stopped may hear no block any more.
TEST_F(RecordingStoreTest, AMarkBeginsASegmentForSomebodyWaitsForIt) {
  start();
  store->note(NoteKind::kMark, 5, 0, "bridge");
  store->close(now);
  EXPECT_EQ(store->durable_marks(), 5);
  ASSERT_EQ(notes(NoteKind::kMark).size(), 1u);
  EXPECT_EQ(notes(NoteKind::kMark)[0].text, "bridge");
}

TEST_F(RecordingStoreTest, AMarkThatHadToWaitBearsTheTimeAtWhichItWasSet) {
  start();
  store->set_clocks(1'790'000'010'000'000, 10'000'000'001);
  store->note(NoteKind::kMark, 5, 0, "bridge", milliseconds(1500));
  store->close(now);
  const Note mark = notes(NoteKind::kMark).at(0);
  EXPECT_EQ(mark.time_us, 1'790'000'008'500'000);
  EXPECT_EQ(mark.host_ns, 8'500'000'001);
}

TEST_F(RecordingStoreTest, NotesASetWallClockAndASleepAndNeitherOfTheOther) {
  constexpr std::int64_t kUtc_us = 1'790'000'000'000'000, kMinute_us = 60'000'000;
  start();
  run(milliseconds(300), 5);
  std::int64_t host_us = 0, utc_us = kUtc_us;
  const auto pass = [&](std::int64_t us, std::int64_t set_us, std::chrono::seconds slept) {
    store->set_clocks(utc_us += us + set_us, 1000 * (host_us += us), slept);
  };
  pass(0, 0, std::chrono::seconds(0));
  pass(40'000, -300, std::chrono::seconds(0));  // slewed
  pass(kMinute_us + 50'000, 0, std::chrono::seconds(60));
  pass(50'000, -kMinute_us, std::chrono::seconds(60));
  pass(2 * kMinute_us, 1'000'000, std::chrono::seconds(90));  // both
  store->close(now);
  const auto slept = notes(NoteKind::kSlept), set = notes(NoteKind::kClockSet);
  ASSERT_EQ(slept.size(), 2u);
  EXPECT_EQ(slept[0].a, kMinute_us);
  EXPECT_EQ(slept[1].a, 30'000'000);
  ASSERT_EQ(set.size(), 2u);
  EXPECT_EQ(set[0].a, -kMinute_us);
  EXPECT_EQ(set[1].a, 1'000'000);
  EXPECT_EQ(store->warnings().size(), 4u);
}

TEST_F(RecordingStoreTest, SaysInTheRecordWhenItStartedAndStoppedAndWhatTheClocksSaid) {
  options.segment_bytes = 1 << 20;  // one only: each repeats the clocks
  start();
  run(milliseconds(25'000), 100);
  note_durable(store->close(now));
  EXPECT_EQ(notes(NoteKind::kStarted).size(), 1u);
  EXPECT_EQ(notes(NoteKind::kStopped).size(), 1u);
  const auto clocks = notes(NoteKind::kClock);
  ASSERT_EQ(clocks.size(), 3u);  // at once, after 10 and after 20 s
  EXPECT_EQ(clocks[0].time_us, 1'790'000'000'000'000);
  EXPECT_EQ(clocks[0].host_ns, 1);
  EXPECT_EQ(clocks[0].incarnation, 1);
}

TEST_F(RecordingStoreTest, WritesWhatAFailedSyncMayHaveLostIntoANewSegmentAtOnce) {
  start();
  run(milliseconds(1000), 20);
  const int segment_before = [&] {
    RecorderStatus status;
    store->fill(status);
    return status.segment;
  }();
  int syncs = 0;
  disk.set_fault([&](DiskCall call, std::int64_t, const std::string&) {
    return Outcome{.error = call == DiskCall::kSyncData && ++syncs == 1 ? EIO : 0};
  });
  run(milliseconds(1000), 20);
  EXPECT_TRUE(store->wants_credit()) << "one failure is no state";
  EXPECT_EQ(durable, 40);
  disk.cut_power();
  disk.power_on();
  EXPECT_EQ(recorded(), test::all_through(40)) << "without asking any node again";
  const auto failures = notes(NoteKind::kDiskFailed);
  ASSERT_EQ(failures.size(), 1u);
  EXPECT_EQ(failures[0].a, EIO);
  EXPECT_EQ(failures[0].b, segment_before);
  EXPECT_NE(failures[0].text.find("fdatasync"), std::string::npos) << failures[0].text;
}

TEST_F(RecordingStoreTest, TakesNoMoreCreditAfterTwoFailuresAndGoesOnTryingEachSecond) {
  start();
  run(milliseconds(1000), 20);
  fail_syncs(EIO);
  run(milliseconds(500), 10);
  EXPECT_EQ(store->state(), RecorderState::kDiskFailing);
  EXPECT_FALSE(store->wants_credit());
  const auto failures = [&] {
    RecorderStatus status;
    store->fill(status);
    return status.disk_failures;
  };
  const std::int64_t failures_before = failures();
  run(milliseconds(10'000));
  EXPECT_NEAR(static_cast<double>(failures() - failures_before), 10.0, 1.0);
  EXPECT_EQ(durable, 20);

  fail_nothing();
  run(milliseconds(1100));
  EXPECT_EQ(store->state(), RecorderState::kRecording);
  EXPECT_EQ(durable, 30);
  EXPECT_EQ(recorded(), test::all_through(30));
  EXPECT_EQ(store->warnings().size(), 3u) << "the two failures, and that all is well";
}

TEST_F(RecordingStoreTest, AReadOnlyDiskIsAStateToo) {
  start();
  run(milliseconds(1000), 20);
  disk.set_read_only(true);
  run(milliseconds(5000), 20);
  EXPECT_EQ(store->state(), RecorderState::kDiskFailing);
  disk.set_read_only(false);
  run(milliseconds(2000), 20);
  EXPECT_EQ(store->state(), RecorderState::kRecording);
  note_durable(store->close(now));
  EXPECT_EQ(recorded(), test::all_through(60));
}

TEST_F(RecordingStoreTest, GoesToTheFallbackFolderWhenTheDiskStaysBadAndContinuesThereAfterARestart) {
  options.fallback = kFallback;
  start();
  run(milliseconds(1000), 20);
  fail({DiskCall::kSyncData, DiskCall::kSync, DiskCall::kWrite}, EIO, kFolder);
  run(milliseconds(3000), 30);
  EXPECT_EQ(store->state(), RecorderState::kRecording);
  note_durable(store->commit(now));
  EXPECT_EQ(durable, 50);
  RecorderStatus status;
  store->fill(status);
  EXPECT_TRUE(status.fallback);
  EXPECT_EQ(notes(NoteKind::kFallback, kFallback).size(), 1u);

  store.reset();
  fail_nothing();
  start();
  EXPECT_EQ(store->folder(), kFallback);
  EXPECT_EQ(store->recovered().epoch.begin()->second.position.contiguous, 50);
  run(milliseconds(1000), 10);
  note_durable(store->close(now));
  auto all = recorded(kFolder);
  for (const std::int64_t sequence : recorded(kFallback)) all.push_back(sequence);
  EXPECT_EQ(all, test::all_through(60)) << "each block once, in the order of the folders";
}

TEST_F(RecordingStoreTest, AFullDiskIsAStateAndNothingIsLostWhenSpaceReturns) {
  options.reserve_bytes = 256 << 10;
  options.ballast_bytes = 64 << 10;
  disk.set_capacity(1 << 20);
  start();
  run(milliseconds(60'000), 3000);  // more than the disk holds
  EXPECT_EQ(store->state(), RecorderState::kDiskFull);
  EXPECT_FALSE(store->wants_credit());
  EXPECT_LT(durable, 3000);
  disk.set_capacity(1 << 30);
  run(milliseconds(3000));
  EXPECT_EQ(store->state(), RecorderState::kRecording);
  EXPECT_EQ(durable, 3000);
  note_durable(store->close(now));
  EXPECT_EQ(recorded(), test::all_through(3000));
  EXPECT_EQ(notes(NoteKind::kDiskFull).size(), 1u);
  EXPECT_EQ(notes(NoteKind::kDiskFree).size(), 1u);
}

TEST_F(RecordingStoreTest, StopsCreditWhileWhatIsUnderWayStillFits) {
  options.reserve_bytes = 256 << 10;
  options.ballast_bytes = 64 << 10;
  disk.set_capacity(1 << 20);
  start();
  while (store->wants_credit()) run(milliseconds(500), 5);
  run(milliseconds(1000), 30);
  run(milliseconds(500));
  EXPECT_EQ(durable, given) << "the reserve is for these";
}

TEST_F(RecordingStoreTest, RetentionDeletesTheOldestSegmentsAndSaysSoInTheRecordBefore) {
  options.keep_bytes = 300 << 10;
  start();
  disk.set_fault([this](DiskCall call, std::int64_t, const std::string& path) {
    if (call == DiskCall::kUnlink && path.ends_with(".lcm")) {
      const int number = std::stoi(path.substr(path.size() - 10, 6));
      const auto said = notes(NoteKind::kSegmentDeleted);
      EXPECT_TRUE(std::any_of(said.begin(), said.end(), [&](const Note& note) { return note.a == number; }));
    }
    return Outcome{};
  });
  run(milliseconds(60'000), 1500);
  note_durable(store->close(now));
  const auto left = recorded();
  ASSERT_FALSE(left.empty());
  EXPECT_GT(left.front(), 1) << "the oldest are gone";
  EXPECT_EQ(left.back(), 1500);
  EXPECT_EQ(left.back() - left.front() + 1, static_cast<std::int64_t>(left.size())) << "and only these";
  RecorderStatus status;
  store->fill(status);
  EXPECT_EQ(status.segments_deleted, static_cast<std::int64_t>(notes(NoteKind::kSegmentDeleted).back().a));

  store.reset();
  fail_nothing();
  start();
  EXPECT_EQ(store->recovered().epoch.begin()->second.position.contiguous, 1500);
}

TEST_F(RecordingStoreTest, SealingClosesTheSegmentAndTheNextBlockBeginsAnother) {
  start();
  run(milliseconds(100), 3);
  store->note(NoteKind::kPowerLost, 0, 0, "supply:AC");
  note_durable(store->seal(now));
  EXPECT_EQ(durable, 3) << "sealed means on the disk";
  EXPECT_EQ(notes(NoteKind::kPowerLost).at(0).text, "supply:AC");
  EXPECT_TRUE(path_exists("/record/seg-000001.idx", disk)) << "a finished segment has an index";
  run(milliseconds(300), 3);
  EXPECT_TRUE(path_exists("/record/seg-000002.lcm", disk));
  EXPECT_EQ(recorded(), test::all_through(6));
}

}  // namespace
}  // namespace roadbalance
