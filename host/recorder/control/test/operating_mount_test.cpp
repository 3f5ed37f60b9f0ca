#include <gtest/gtest.h>

#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"
#include "common/record/folder.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "host/recorder/control/operating.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr const char* kRecordings = "/recordings";
constexpr std::int64_t kNow = 1'769'860'805'000'000;

/// The results of the sessions that were begun.
struct Course {
  bool has_samples = false;
  RecorderState state = RecorderState::kRecording;
  bool is_over = false;
  std::string error;
  bool fallback = false;
  std::vector<NoteToRecord> marks{};  // noted
};

class Played final : public Session {
 public:
  explicit Played(Course& course) : course_(course) {}
  void stop(const std::string&) override {}
  void note(NoteToRecord note) override {
    if (note.kind == NoteKind::kMark) course_.marks.push_back(std::move(note));
  }
  View view() const override {
    RecorderReport report;
    if (course_.has_samples) {
      report.node.emplace_back();
      report.node.back().node = 1;
      report.node.back().samples_recorded = 100;
      report.node.back().has_durable_samples = true;
    }
    return {.report = std::move(report),
            .status = RecorderStatus{.state = course_.state, .fallback = course_.fallback},
            .is_over = course_.is_over,
            .error = course_.error};
  }

 private:
  Course& course_;
};

/// The recordings are on a disk that is mounted at their folder.
class OperatingMountTest : public ::testing::Test {
 protected:
  OperatingMountTest() {
    create_folders(kRecordings, disk);
    disk.mount(kRecordings);
    options.recordings = kRecordings;
    options.recorder.on_warning = [this](const std::string& sentence) { warnings.push_back(sentence); };
  }
  void begin(std::optional<std::string> start) {
    options.start = std::move(start);
    operating.emplace(options,
                      Operating::World{.disk = disk,
                                       .begin =
                                           [this](RecorderOptions of) {
                                             begun.push_back(std::move(of));
                                             return std::make_unique<Played>(course);
                                           },
                                       .seed = 1},
                      Operating::Time{.now = now, .utc_us = kNow});
  }
  void run(milliseconds length) {
    for (const WallTime end = now + length; now < end; now += milliseconds(100))
      (void)operating->turn(false, {.now = now, .utc_us = kNow},
                            [](const std::string&, auto) { return true; });
  }
  void ask(Request request) {
    request.asker = 5;
    operating->take(kRequestChannel, encode(request), {.now = now, .utc_us = kNow});
  }
  bool beneath_is_empty() {
    const auto names = disk.list(kRecordings);
    return names && names->empty();
  }

  test::SimulatedDisk disk;
  OperateOptions options;
  Course course;
  WallTime now{std::chrono::hours(1)};
  std::vector<RecorderOptions> begun;
  std::vector<std::string> warnings;
  std::optional<Operating> operating;
};

TEST_F(OperatingMountTest, ARecordingThatHasRunIsContinuedAndNeverBegunBeneathItsDisk) {
  begin("drive");
  ASSERT_EQ(begun.size(), 1u);
  EXPECT_FALSE(begun[0].continues);
  course.has_samples = true;
  run(milliseconds(1000));
  disk.unmount(kRecordings);
  ask({.request = 1, .operation = Operation::kStop});
  course = {.has_samples = false, .is_over = true, .error = "recording /recordings/drive (mount its disk)"};
  run(milliseconds(500));
  course = {};
  run(milliseconds(3000));
  ASSERT_EQ(begun.size(), 2u);
  EXPECT_TRUE(begun[1].continues);
  EXPECT_TRUE(beneath_is_empty()) << "the session state is on the disk that is not mounted";
  disk.mount(kRecordings);
  run(milliseconds(2000));
  const SessionState state = read_session_state(kRecordings, disk);
  ASSERT_TRUE(state.active);
  EXPECT_TRUE(state.active->stop) << "written as soon as the disk is back";
}

TEST_F(OperatingMountTest, NothingIsBegunBeneathADiskOnWhichNothingWasBegunYet) {
  begin(std::nullopt);
  disk.unmount(kRecordings);
  const Heartbeat beat{.node = 1, .epoch = 3, .state = NodeState::kPreview};
  operating->take(heartbeat_channel(1), encode(beat), {.now = now, .utc_us = kNow});
  ask({.request = 1, .operation = Operation::kStart, .text = "drive"});
  run(milliseconds(2000));
  EXPECT_TRUE(begun.empty());
  EXPECT_TRUE(beneath_is_empty());
  disk.mount(kRecordings);
  operating->take(heartbeat_channel(1), encode(beat), {.now = now, .utc_us = kNow});
  ask({.request = 2, .operation = Operation::kStart, .text = "drive"});
  EXPECT_EQ(begun.size(), 1u);
}

TEST_F(OperatingMountTest, ADiskThatIsPluggedInAnewIsKnownByItsBook) {
  begin("drive");
  disk.pull_out(kRecordings);
  ask({.request = 1, .operation = Operation::kStop});
  run(milliseconds(2000));
  EXPECT_TRUE(beneath_is_empty());
  disk.plug_in(kRecordings);
  run(milliseconds(2000));
  EXPECT_TRUE(read_session_state(kRecordings, disk).active->stop);
  EXPECT_THROW((void)claim_session_state(kRecordings, disk), std::runtime_error) << "it is ours again";
}

TEST_F(OperatingMountTest, ADiskThatFailsCanBeUnmountedAndIsClaimedAgain) {
  begin("drive");
  run(milliseconds(500));
  EXPECT_EQ(disk.open_files(), 1u) << "the folder that no other recorder may have";
  course.state = RecorderState::kDiskFailing;
  run(milliseconds(500));
  EXPECT_EQ(disk.open_files(), 0u);
  course.state = RecorderState::kRecording;
  run(milliseconds(500));
  EXPECT_THROW(claim_session_state(kRecordings, disk), std::runtime_error);
  EXPECT_TRUE(warnings.empty());
}

TEST_F(OperatingMountTest, ADiskThatWasClaimedByAnotherIsAskedForAgain) {
  begin("drive");
  course.state = RecorderState::kDiskFailing;
  run(milliseconds(500));
  std::optional<File> other = claim_session_state(kRecordings, disk);
  course.state = RecorderState::kRecording;
  run(milliseconds(5000));
  EXPECT_EQ(warnings.size(), 1u) << "said once";
  other.reset();
  run(milliseconds(2000));
  EXPECT_THROW(claim_session_state(kRecordings, disk), std::runtime_error);
}

TEST_F(OperatingMountTest, AnotherDiskIsWantedOnceThereIsNoWork) {
  begin(std::nullopt);
  EXPECT_FALSE(operating->has_another_disk());
  disk.unmount(kRecordings);
  EXPECT_FALSE(operating->has_another_disk()) << "what lies beneath is no disk";
  disk.plug_in(kRecordings);
  EXPECT_TRUE(operating->has_another_disk());
  begin("drive");
  EXPECT_FALSE(operating->has_another_disk());
  disk.plug_in(kRecordings);
  EXPECT_FALSE(operating->has_another_disk()) << "it is waited for the one that is recorded to";
}

TEST_F(OperatingMountTest, TheBookOfAnotherDiskIsLeftAlone) {
  begin("drive");
  disk.unmount(kRecordings);
  SessionState others;
  others.past = {{"other", 1, 2}};
  write_session_state(kRecordings, others, disk);
  ask({.request = 1, .operation = Operation::kStop});
  run(milliseconds(2000));
  EXPECT_EQ(read_session_state(kRecordings, disk).past, others.past);
}

// Killed before its session state has it, a recorder would leave a mark in the record whose number the next
// one gives to another.
TEST_F(OperatingMountTest, AMarkIsNotedWhenTheBookHasItAndKeepsItsTime) {
  begin("drive");
  course.has_samples = true;
  run(milliseconds(1000));
  ask({.request = 1, .operation = Operation::kMark, .text = "kerb"});
  run(milliseconds(100));
  ASSERT_EQ(course.marks.size(), 1u);
  disk.unmount(kRecordings);
  const WallTime asked_at = now;
  ask({.request = 2, .operation = Operation::kMark, .text = "bridge"});
  run(milliseconds(3000));
  EXPECT_EQ(course.marks.size(), 1u);
  disk.mount(kRecordings);
  run(milliseconds(1500));
  ASSERT_EQ(course.marks.size(), 2u);
  EXPECT_EQ(course.marks[1].text, "bridge");
  EXPECT_EQ(course.marks[1].a, 2);
  EXPECT_EQ(course.marks[1].at, asked_at);
}

TEST_F(OperatingMountTest, AMarkInARecordElsewhereDoesNotWaitForTheBook) {
  begin("drive");
  course.has_samples = true;
  run(milliseconds(1000));
  disk.unmount(kRecordings);
  course.fallback = true;
  ask({.request = 1, .operation = Operation::kMark, .text = "kerb"});
  run(milliseconds(100));
  EXPECT_EQ(course.marks.size(), 1u);
}

}  // namespace
}  // namespace roadbalance
