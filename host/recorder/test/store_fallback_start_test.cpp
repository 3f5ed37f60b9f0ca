// A start whose first folder can no longer be gone on with: its blocks that count, and the warnings.
#include <gtest/gtest.h>

#include <cerrno>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "host/recorder/test/store_drive.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using test::DiskCall;
using test::Drive;
using test::kFolder;
using test::Outcome;

constexpr const char* kFallback = "/other";
constexpr std::uint64_t kTorn = 500;

class StoreFallbackStartTest : public ::testing::Test, protected test::Drive {
 protected:
  /// A drive of 50 blocks, of which the last 30 went to the fallback, and whose recorder was killed.
  void drive_into_the_fallback() {
    options.fallback = kFallback;
    start();
    run(milliseconds(1000), 20);
    fail({DiskCall::kSyncData, DiskCall::kSync, DiskCall::kWrite}, EIO, kFolder);
    run(milliseconds(3000), 30);
    disk.kill();
    store.reset();
    fail_nothing();
  }
  /// Bytes that are no event behind the last one, as a power cut leaves them.
  std::string tear_last_segment(const char* folder) {
    const int last = segment_numbers(folder, disk).back();
    const std::string segment = segment_path(folder, last).string();
    disk.unlink(index_path(folder, last).c_str());
    auto bytes = disk.content(segment);
    bytes.insert(bytes.end(), kTorn, 'x');
    disk.put(segment, bytes);
    return segment;
  }
};

TEST_F(StoreFallbackStartTest, StartsInTheFallbackFolderWhenTheFirstCanOnlyBeRead) {
  start();
  run(milliseconds(1000), 20);
  store->close(now);
  store.reset();
  options.fallback = kFallback;
  fail({DiskCall::kSync, DiskCall::kWrite}, EROFS, kFolder);
  start();
  EXPECT_EQ(store->folder(), kFallback);
  EXPECT_EQ(store->recovered().epoch.begin()->second.position.contiguous, 20);
}

// The calls that a disk refuses which is mounted read-only, and one that is full to the last byte: a sync
// succeeds.
class UnwritableStartTest : public StoreFallbackStartTest, public ::testing::WithParamInterface<int> {
 protected:
  void make_unwritable() {
    std::vector<DiskCall> refused{DiskCall::kWrite, DiskCall::kReserve, DiskCall::kMakeFolder};
    if (GetParam() == EROFS)
      refused.insert(refused.end(), {DiskCall::kTruncate, DiskCall::kRename, DiskCall::kUnlink});
    fail(std::move(refused), GetParam(), kFolder);
  }
};

TEST_P(UnwritableStartTest, AFolderThatWasFinishedGoesOnInTheFallback) {
  start();
  run(milliseconds(1000), 20);
  note_durable(store->close(now));
  store.reset();
  options.fallback = kFallback;
  make_unwritable();
  start();
  EXPECT_EQ(store->folder(), kFallback);
  EXPECT_EQ(store->recovered().epoch.begin()->second.position.contiguous, 20);
  run(milliseconds(1000), 10);
  note_durable(store->close(now));
  EXPECT_EQ(durable, 30);
  EXPECT_EQ(recorded(kFallback).size(), 10u);
}

TEST_P(UnwritableStartTest, AnEmptyFolderIsBegunInTheFallback) {
  ASSERT_EQ(disk.mkdir(kFolder, 0755), 0);
  options.fallback = kFallback;
  make_unwritable();
  start();
  EXPECT_EQ(store->folder(), kFallback);
  run(milliseconds(1000), 10);
  note_durable(store->close(now));
  EXPECT_EQ(recorded(kFallback).size(), 10u);
}

TEST_P(UnwritableStartTest, WithoutAFallbackTheFileIsNamed) {
  ASSERT_EQ(disk.mkdir(kFolder, 0755), 0);
  make_unwritable();
  try {
    start();
    FAIL() << "nothing can be recorded";
  } catch (const std::system_error& error) {
    EXPECT_NE(std::string(error.what()).find(kFolder), std::string::npos) << error.what();
    EXPECT_EQ(error.code().value(), GetParam());
  }
}

INSTANTIATE_TEST_SUITE_P(Disks, UnwritableStartTest, ::testing::Values(EROFS, ENOSPC));

// A sync failed, the recorder is killed, and the disk is mounted read-only: what was written and never called
// durable is in the page cache.  Blocks 1 to 20 are durable, 21 to 50 are not sure.
void start_again_on_a_disk_that_became_read_only(Drive& drive) {
  drive.options.segment_bytes = 128 << 10;  // one is enough
  drive.start();
  drive.run(milliseconds(1000), 20);
  ASSERT_EQ(drive.durable, 20);
  drive.run(milliseconds(100), 30);
  drive.fail({DiskCall::kSyncData, DiskCall::kSync, DiskCall::kTruncate}, EIO);
  EXPECT_TRUE(drive.store->commit(drive.now).empty());
  drive.disk.kill();
  drive.store.reset();
  drive.options.fallback = kFallback;
  drive.fail({DiskCall::kSync, DiskCall::kWrite, DiskCall::kTruncate}, EROFS, kFolder);
  drive.start();
}

TEST_F(StoreFallbackStartTest, WritesWhatTheFirstFolderMayLoseToTheFallbackBeforeItCounts) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Drive drive(seed);
    start_again_on_a_disk_that_became_read_only(drive);
    const std::int64_t counted = drive.store->recovered().epoch.begin()->second.position.contiguous;
    EXPECT_EQ(counted, 50) << "all could be read";
    drive.disk.cut_power();
    drive.store.reset();
    drive.disk.power_on();
    drive.fail_nothing();
    std::set<std::int64_t> left;
    for (const char* folder : {kFolder, kFallback})
      if (path_exists(std::string(folder) + "/seg-000001.lcm", drive.disk))
        for (const std::int64_t sequence : drive.recorded(folder)) left.insert(sequence);
    for (std::int64_t sequence = 1; sequence <= counted; ++sequence)
      EXPECT_TRUE(left.contains(sequence)) << sequence << " of " << counted << ", seed " << seed;
  }
}

TEST_F(StoreFallbackStartTest, TheJournalOfTheFallbackAgreesWithItsBlocksBehindThoseOfTheFirstFolder) {
  start_again_on_a_disk_that_became_read_only(*this);
  run(milliseconds(2000), 20);
  note_durable(store->close(now));
  EXPECT_EQ(recorded(kFallback).size(), 50u) << "30 of the first folder, and 20";
  const Verification found = verify_record(kFallback, disk);
  EXPECT_GT(found.journal_entries, 0);
  ASSERT_EQ(found.epoch.size(), 1u);
  EXPECT_TRUE(found.epoch[0].contradictions.empty()) << found.epoch[0].contradictions[0];
}

TEST_F(StoreFallbackStartTest, TheNoteOfTheStartNamesTheSegmentThatItIsIn) {
  start_again_on_a_disk_that_became_read_only(*this);
  run(milliseconds(2000), 20);
  note_durable(store->close(now));
  const auto started = notes(NoteKind::kStarted, kFallback);
  ASSERT_EQ(started.size(), 1u);
  EXPECT_EQ(started[0].a, 1) << "the blocks written again have begun it";
  EXPECT_EQ(notes(NoteKind::kStarted)[0].a, 1) << "that is what it is called where nothing is written again";
}

TEST_F(StoreFallbackStartTest, TailsThatAreCutOffInBothFoldersAreToldInTheFallback) {
  drive_into_the_fallback();
  const std::string first = tear_last_segment(kFolder), second = tear_last_segment(kFallback);
  start();
  ASSERT_EQ(store->cut_tails().size(), 2u);
  EXPECT_EQ(store->cut_tails()[0].segment, first);
  EXPECT_EQ(store->cut_tails()[0].cut, kTorn);
  EXPECT_EQ(store->cut_tails()[1].segment, second);
  EXPECT_EQ(store->cut_tails()[1].cut, kTorn);
  run(milliseconds(1000), 10);
  note_durable(store->close(now));
  const auto cut = notes(NoteKind::kTailCut, kFallback);
  ASSERT_EQ(cut.size(), 2u);
  EXPECT_EQ(cut[0].a, segment_of_file(std::filesystem::path(first).filename().string(), ".lcm"));
  EXPECT_EQ(cut[0].b, kTorn);
  EXPECT_EQ(cut[0].text, store->cut_tails()[0].tail) << "the other folder has segments of these numbers, too";
  EXPECT_EQ(cut[1].b, kTorn);
  EXPECT_EQ(cut[1].text, store->cut_tails()[1].tail.filename());
}

// A gap for all of it would call lost what can be read around the sector.
TEST_F(StoreFallbackStartTest, ABadSectorOfTheFirstFolderCostsWhatIsInIt) {
  start();
  run(milliseconds(2000), 30);
  ASSERT_EQ(segment_numbers(kFolder, disk).size(), 1u);
  disk.kill();
  store.reset();
  options.fallback = kFallback;
  disk.spoil("/record/seg-000001.lcm", 8 << 10);
  start();
  EXPECT_EQ(store->folder(), kFallback);
  EXPECT_EQ(store->recovered().epoch.begin()->second.position.contiguous, durable);
  EXPECT_GT(durable, 20);
  EXPECT_TRUE(was_warned_of("of what /record holds counts only what can be read"));
}

// Measuring goes before order: what the first folder held stays there for rb recover.
TEST_F(StoreFallbackStartTest, AFirstFolderThatCannotBeReadKeepsNobodyFromRecording) {
  start();
  run(milliseconds(1000), 20);
  disk.kill();
  store.reset();
  const auto before = disk.content("/record/seg-000001.lcm");
  options.fallback = kFallback;
  disk.set_fault([](DiskCall call, std::int64_t, const std::string& path) {
    return Outcome{.error = call == DiskCall::kRead && path == "/record/seg-000001.lcm" ? EIO : 0};
  });
  start();
  EXPECT_EQ(store->folder(), kFallback);
  EXPECT_TRUE(store->recovered().epoch.empty());
  EXPECT_TRUE(was_warned_of("of what /record holds counts only what can be read"));
  run(milliseconds(1000), 10);
  note_durable(store->close(now));
  EXPECT_EQ(recorded(kFallback).size(), 10u);
  EXPECT_EQ(disk.content("/record/seg-000001.lcm"), before) << "nothing is cut where nothing can be read";

  store.reset();
  options.fallback.clear();
  EXPECT_THROW(start(), std::runtime_error) << "there is nowhere else";
}

}  // namespace
}  // namespace roadbalance
