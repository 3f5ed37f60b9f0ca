#include "host/recorder/record_keeper.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>

#include "common/bus/codec.hpp"
#include "common/record/folder.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using test::DiskCall;
using test::SimulatedDisk;
using Outcome = SimulatedDisk::Outcome;

constexpr const char* kFolder = "/record";
constexpr const char* kFallback = "/other";

// A keeper on a disk of its own, fed with blocks.
class Drive {
 public:
  explicit Drive(std::uint64_t seed = 3) : disk(seed) {}

  RecordKeeper& start() {
    keeper.emplace(disk, options);
    keeper->set_clocks(1'790'000'000'000'000, 1);
    keeper->begin(1);
    return *keeper;
  }

  // Time passes; so many blocks come, evenly, and what is due is done.
  void run(milliseconds duration, int blocks = 0) {
    const std::int64_t first = given;
    constexpr milliseconds kStep{10};
    for (milliseconds t{0}; t < duration; t += kStep) {
      now += kStep;
      while (given < first + blocks * (t + kStep) / duration)
        keeper->append(Delivery(test::numbered_block(++given)), now);
      if (keeper->commit_is_due(now)) note_durable(keeper->commit(now));
    }
  }
  void note_durable(const std::vector<DurableMark>& marks) {
    for (const auto& mark : marks) {
      EXPECT_GT(mark.sequence, durable);
      durable = mark.sequence;
    }
  }
  // Numbers of the blocks in the record, in its order, each with the bytes it was given.
  std::vector<std::int64_t> recorded(const char* folder = kFolder) {
    std::vector<std::int64_t> found;
    RecordReader reader(folder, disk);
    reader.finish();
    SealedBlock block;
    while (const auto event = reader.next()) {
      if (accept(event->data, block) != Refusal::kNone || block.header.sequence == 0) continue;
      EXPECT_TRUE(std::ranges::equal(test::numbered_block(block.header.sequence).bytes(), event->data));
      found.push_back(block.header.sequence);
    }
    return found;
  }
  std::vector<Note> notes(NoteKind kind, const char* folder = kFolder) {
    std::vector<Note> found;
    RecordReader reader(folder, disk);
    reader.finish();
    while (const auto event = reader.next())
      if (const auto note = event->channel == kNoteChannel ? decode_note(event->data) : std::nullopt)
        if (note->kind == kind) found.push_back(*note);
    return found;
  }
  // Calls of these kinds fail from now on.
  void fail(std::vector<DiskCall> kinds, int error) {
    disk.set_fault([kinds, error](DiskCall call, std::int64_t, const std::string&) {
      return Outcome{.error = std::find(kinds.begin(), kinds.end(), call) == kinds.end() ? 0 : error};
    });
  }
  void fail_nothing() { disk.set_fault(nullptr); }
  void fail_syncs(int error) { fail({DiskCall::kSyncData, DiskCall::kSync}, error); }

  SimulatedDisk disk;
  KeeperOptions options{.folder = kFolder, .segment_bytes = 64 << 10};
  std::optional<RecordKeeper> keeper;
  WallTime now = WallTime(std::chrono::hours(1));
  std::int64_t given = 0;
  std::int64_t durable = 0;
};

class KeeperTest : public ::testing::Test, protected Drive {};

TEST_F(KeeperTest, CommitsAsAGroupWhenTheFirstBlockIsOldEnough) {
  start();
  run(milliseconds(50), 5);
  EXPECT_EQ(durable, 0);
  run(milliseconds(200));
  EXPECT_EQ(durable, 5);
  EXPECT_EQ(recorded(), test::all_through(5));
}

TEST_F(KeeperTest, CommitsAtOnceWhenThereIsMuch) {
  options.commit_bytes = 20'000;
  start();
  run(milliseconds(10), 40);
  EXPECT_EQ(durable, 40);
}

TEST_F(KeeperTest, NotesAloneBeginNoSegment) {
  start();
  run(milliseconds(5000));
  keeper->close(now);
  EXPECT_FALSE(path_exists("/record/seg-000001.lcm", disk));
}

TEST_F(KeeperTest, SaysInTheRecordWhenItStartedAndStoppedAndWhatTheClocksSaid) {
  start();
  run(milliseconds(25'000), 100);
  note_durable(keeper->close(now));
  EXPECT_EQ(notes(NoteKind::kStarted).size(), 1u);
  EXPECT_EQ(notes(NoteKind::kStopped).size(), 1u);
  const auto clocks = notes(NoteKind::kClock);
  ASSERT_EQ(clocks.size(), 3u);  // at once, after 10 and after 20 s
  EXPECT_EQ(clocks[0].time_us, 1'790'000'000'000'000);
  EXPECT_EQ(clocks[0].host_ns, 1);
  EXPECT_EQ(clocks[0].incarnation, 1);
}

TEST_F(KeeperTest, WritesWhatAFailedSyncMayHaveLostIntoANewSegmentAtOnce) {
  start();
  run(milliseconds(1000), 20);
  const int segment_before = [&] {
    RecorderStatus status;
    keeper->fill(status);
    return status.segment;
  }();
  int syncs = 0;
  disk.set_fault([&](DiskCall call, std::int64_t, const std::string&) {
    return Outcome{.error = call == DiskCall::kSyncData && ++syncs == 1 ? EIO : 0};
  });
  run(milliseconds(1000), 20);
  EXPECT_TRUE(keeper->wants_credit()) << "one failure is no state";
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

TEST_F(KeeperTest, TakesNoMoreCreditAfterTwoFailuresAndGoesOnTryingEachSecond) {
  start();
  run(milliseconds(1000), 20);
  fail_syncs(EIO);
  run(milliseconds(500), 10);
  EXPECT_EQ(keeper->state(), RecorderState::kDiskFailing);
  EXPECT_FALSE(keeper->wants_credit());
  const auto failures = [&] {
    RecorderStatus status;
    keeper->fill(status);
    return status.disk_failures;
  };
  const std::int64_t failures_before = failures();
  run(milliseconds(10'000));
  EXPECT_NEAR(static_cast<double>(failures() - failures_before), 10.0, 1.0);
  EXPECT_EQ(durable, 20);

  fail_nothing();
  run(milliseconds(1100));
  EXPECT_EQ(keeper->state(), RecorderState::kRecording);
  EXPECT_EQ(durable, 30);
  EXPECT_EQ(recorded(), test::all_through(30));
  EXPECT_EQ(keeper->warnings().size(), 3u) << "the two failures, and that all is well";
}

TEST_F(KeeperTest, AReadOnlyDiskIsAStateToo) {
  start();
  run(milliseconds(1000), 20);
  disk.set_read_only(true);
  run(milliseconds(5000), 20);
  EXPECT_EQ(keeper->state(), RecorderState::kDiskFailing);
  disk.set_read_only(false);
  run(milliseconds(2000), 20);
  EXPECT_EQ(keeper->state(), RecorderState::kRecording);
  note_durable(keeper->close(now));
  EXPECT_EQ(recorded(), test::all_through(60));
}

TEST_F(KeeperTest, GoesToTheFallbackFolderWhenTheDiskStaysBadAndContinuesThereAfterARestart) {
  options.fallback = kFallback;
  start();
  run(milliseconds(1000), 20);
  disk.set_fault([](DiskCall call, std::int64_t, const std::string& path) {
    const bool changes = call == DiskCall::kSyncData || call == DiskCall::kSync || call == DiskCall::kWrite;
    return Outcome{.error = changes && path.starts_with(kFolder) ? EIO : 0};
  });
  run(milliseconds(3000), 30);
  EXPECT_EQ(keeper->state(), RecorderState::kRecording);
  note_durable(keeper->commit(now));
  EXPECT_EQ(durable, 50);
  RecorderStatus status;
  keeper->fill(status);
  EXPECT_TRUE(status.fallback);
  EXPECT_EQ(notes(NoteKind::kFallback, kFallback).size(), 1u);

  keeper.reset();
  fail_nothing();
  start();
  EXPECT_EQ(keeper->folder(), kFallback);
  EXPECT_EQ(keeper->recovered().epoch.begin()->second.position.contiguous, 50);
  run(milliseconds(1000), 10);
  note_durable(keeper->close(now));
  auto all = recorded(kFolder);
  for (const std::int64_t sequence : recorded(kFallback)) all.push_back(sequence);
  EXPECT_EQ(all, test::all_through(60)) << "each block once, in the order of the folders";
}

TEST_F(KeeperTest, StartsInTheFallbackFolderWhenTheFirstCanOnlyBeRead) {
  start();
  run(milliseconds(1000), 20);
  keeper->close(now);
  keeper.reset();
  options.fallback = kFallback;
  disk.set_fault([](DiskCall call, std::int64_t, const std::string& path) {
    const bool changes = call == DiskCall::kSync || call == DiskCall::kWrite;
    return Outcome{.error = changes && path.starts_with(kFolder) ? EROFS : 0};
  });
  start();
  EXPECT_EQ(keeper->folder(), kFallback);
  EXPECT_EQ(keeper->recovered().epoch.begin()->second.position.contiguous, 20);
}

TEST_F(KeeperTest, AFullDiskIsAStateAndNothingIsLostWhenSpaceReturns) {
  options.reserve_bytes = 256 << 10;
  options.ballast_bytes = 64 << 10;
  disk.set_capacity(1 << 20);
  start();
  run(milliseconds(60'000), 3000);  // more than the disk holds
  EXPECT_EQ(keeper->state(), RecorderState::kDiskFull);
  EXPECT_FALSE(keeper->wants_credit());
  EXPECT_LT(durable, 3000);
  disk.set_capacity(1 << 30);
  run(milliseconds(3000));
  EXPECT_EQ(keeper->state(), RecorderState::kRecording);
  EXPECT_EQ(durable, 3000);
  note_durable(keeper->close(now));
  EXPECT_EQ(recorded(), test::all_through(3000));
  EXPECT_EQ(notes(NoteKind::kDiskFull).size(), 1u);
  EXPECT_EQ(notes(NoteKind::kDiskFree).size(), 1u);
}

TEST_F(KeeperTest, StopsCreditWhileWhatIsUnderWayStillFits) {
  options.reserve_bytes = 256 << 10;
  options.ballast_bytes = 64 << 10;
  disk.set_capacity(1 << 20);
  start();
  while (keeper->wants_credit()) run(milliseconds(500), 5);
  run(milliseconds(1000), 30);
  run(milliseconds(500));
  EXPECT_EQ(durable, given) << "the reserve is for these";
}

TEST_F(KeeperTest, RetentionDeletesTheOldestSegmentsAndSaysSoInTheRecordBefore) {
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
  note_durable(keeper->close(now));
  const auto left = recorded();
  ASSERT_FALSE(left.empty());
  EXPECT_GT(left.front(), 1) << "the oldest are gone";
  EXPECT_EQ(left.back(), 1500);
  EXPECT_EQ(left.back() - left.front() + 1, static_cast<std::int64_t>(left.size())) << "and only these";
  RecorderStatus status;
  keeper->fill(status);
  EXPECT_EQ(status.segments_deleted, static_cast<std::int64_t>(notes(NoteKind::kSegmentDeleted).back().a));

  keeper.reset();
  fail_nothing();
  start();
  EXPECT_EQ(keeper->recovered().epoch.begin()->second.position.contiguous, 1500);
}

TEST_F(KeeperTest, SealingClosesTheSegmentAndTheNextBlockBeginsAnother) {
  start();
  run(milliseconds(100), 3);
  keeper->note(NoteKind::kPowerLost, 0, 0, "supply:AC");
  note_durable(keeper->seal(now));
  EXPECT_EQ(durable, 3) << "sealed means on the disk";
  EXPECT_EQ(notes(NoteKind::kPowerLost).at(0).text, "supply:AC");
  EXPECT_TRUE(path_exists("/record/seg-000001.idx", disk)) << "a finished segment has an index";
  run(milliseconds(300), 3);
  EXPECT_TRUE(path_exists("/record/seg-000002.lcm", disk));
  EXPECT_EQ(recorded(), test::all_through(6));
}

// For every call in turn, alone or with those that follow: whatever is said to be durable is there after a
// power cut, and once the disk works again everything is there, without help of the nodes.
class EveryCall : public ::testing::TestWithParam<Outcome> {
 protected:
  // False if the drive has no such call.
  bool drive_with_fault_at(std::int64_t first, std::int64_t count, bool power_cut) {
    Drive drive(static_cast<std::uint64_t>(first));
    drive.options.segment_bytes = 16 << 10;
    drive.disk.set_fault([&](DiskCall, std::int64_t number, const std::string&) {
      return number >= first && number < first + count ? GetParam() : Outcome{};
    });
    try {
      drive.start();
    } catch (const std::system_error&) {
      return true;  // a start may fail: its supervisor tries again
    }
    drive.run(milliseconds(2000), 40);
    const bool reached = drive.disk.calls() >= first;
    if (power_cut) {
      drive.disk.cut_power();
      drive.keeper.reset();
      drive.disk.power_on();
    } else {
      drive.run(milliseconds(1000) * (count + 1));
      drive.note_durable(drive.keeper->close(drive.now));
      EXPECT_EQ(drive.durable, 40) << "fault at call " << first;
    }
    if (drive.durable == 0) return reached;
    drive.fail_nothing();
    const auto found = drive.recorded();
    EXPECT_TRUE(std::ranges::includes(found, test::all_through(drive.durable)))
        << drive.durable << " promised, fault at call " << first << ", " << count << " times";
    return reached;
  }
};

TEST_P(EveryCall, ThatFailsLeadsToNoPromiseThatIsNotKept) {
  for (const bool power_cut : {true, false})
    for (const std::int64_t count : {1, 2, 7}) {
      std::int64_t k = 1;
      while (drive_with_fault_at(k, count, power_cut) && !HasFailure()) ++k;
      EXPECT_GT(k, 50) << "the drive has too few calls to prove much";
    }
}

INSTANTIATE_TEST_SUITE_P(EachError, EveryCall,
                         ::testing::Values(Outcome{.error = EIO}, Outcome{.error = ENOSPC},
                                           Outcome{.error = EROFS}, Outcome{.error = EINTR},
                                           Outcome{.short_write = true}));

}  // namespace
}  // namespace roadbalance
