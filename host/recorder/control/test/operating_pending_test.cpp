#include "host/recorder/control/operating.hpp"

#include <gtest/gtest.h>

#include "common/bus/bus.hpp"
#include "common/bus/control_messages.hpp"
#include "common/test/temporary_directory.hpp"
#include "host/recorder/incarnation.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr std::int64_t kNow = 1'769'860'805'000'000;
constexpr std::int64_t kBefore = kNow / 1000 + 3'600'000;  // incarnations of "drive": the clock was ahead

/// A recording that runs until it is destroyed.
class Running final : public Session {
 public:
  void stop(const std::string&) override {}
  void note(NoteToRecord) override {}
  View view() const override { return {.report = {}, .status = RecorderStatus{}, .error = ""}; }
};

/// One that has ended with a higher number than its last report had.
class Ended final : public Session {
 public:
  void stop(const std::string&) override {}
  void note(NoteToRecord) override {}
  View view() const override {
    return {.report = {.node = {}, .incarnation = kRaised},
            .status = RecorderStatus{.incarnation = kRaised - 1},
            .is_over = true,
            .error = ""};
  }
  static constexpr std::int64_t kRaised = kBefore + 5000;
};

class OperatingTest : public ::testing::Test {
 protected:
  OperatingTest() {
    options.recordings = work.path();
    std::filesystem::create_directory(work.path() / "drive");
    for (const std::int64_t of_drive : {kBefore, kBefore + 50, kBefore + 100})
      keep_incarnation(work.path() / "drive", of_drive);
    state.past = {{"drive", kBefore, kBefore + 100}};
    write_session_state(work.path(), state);
  }
  Operating::Time time() const { return {.now = now, .utc_us = utc_us}; }
  /// Sessions run until they are destroyed.
  void operate() {
    operating.emplace(options,
                      Operating::World{.disk = kernel_disk(),
                                       .begin =
                                           [this](RecorderOptions of) {
                                             begun.push_back(std::move(of));
                                             return std::make_unique<Running>();
                                           },
                                       .seed = 1},
                      time());
  }
  /// A node that was started for "drive" is heard.
  void run(milliseconds length) {
    const Heartbeat beat{
        .node = 2, .epoch = 77, .base = 1, .next = 9, .state = NodeState::kStarted, .owner = owner};
    for (const WallTime end = now + length; now < end; now += milliseconds(100), utc_us += 100'000) {
      operating->take(heartbeat_channel(2), encode(beat), time());
      (void)operating->turn(false, time(), [](const std::string&, auto) { return true; });
    }
  }

  test::TemporaryDirectory work;
  OperateOptions options;
  WallTime now{std::chrono::hours(1)};
  std::int64_t utc_us = kNow;
  std::int64_t owner = kBefore + 50;
  SessionState state;
  std::vector<RecorderOptions> begun;
  std::optional<Operating> operating;
};

TEST_F(OperatingTest, ANodeThatIsBackDuringTheNextRecordingIsFetchedIntoItsOwn) {
  options.start = "next";
  operate();
  ASSERT_EQ(begun.size(), 1u);
  EXPECT_EQ(begun[0].folder.filename(), "next");
  EXPECT_TRUE(begun[0].scope.is_former(kBefore + 50));
  EXPECT_GT(begun[0].first_incarnation, kBefore + 100) << "else nobody could tell whose a node's samples are";
  EXPECT_FALSE(begun[0].scope.is_former(begun[0].first_incarnation));
  run(milliseconds(4000));
  ASSERT_EQ(begun.size(), 2u);
  EXPECT_EQ(begun[1].folder.filename(), "drive");
  EXPECT_FALSE(begun[1].start);
  EXPECT_EQ(begun[1].scope.only, (std::vector<NodeEpoch>{{2, 77}}));
}

TEST_F(OperatingTest, ANumberThatWasRaisedAtTheLastMomentIsOfItsRecording) {
  options.start = "next";
  operating.emplace(options,
                    Operating::World{.disk = kernel_disk(),
                                     .begin = [](RecorderOptions) { return std::make_unique<Ended>(); },
                                     .seed = 1},
                    time());
  (void)operating->turn(false, time(), [](const std::string&, auto) { return true; });
  state = read_session_state(work.path());
  ASSERT_FALSE(state.past.empty());
  EXPECT_EQ(state.past.back().recording, "next");
  EXPECT_EQ(state.past.back().last_incarnation, Ended::kRaised);
}

// A folder that is gone is not asked for again and again: the session state is written with two syncs.
TEST_F(OperatingTest, ARestOfARecordingThatWasMovedAwayIsNotOwed) {
  std::filesystem::remove_all(work.path() / "drive");
  int warnings = 0;
  options.recorder.on_warning = [&warnings](const std::string&) { ++warnings; };
  operate();
  run(milliseconds(10'000));
  EXPECT_EQ(warnings, 0);
  EXPECT_TRUE(read_session_state(work.path()).pending.empty());
  std::filesystem::create_directory(work.path() / "drive");  // moved back
  run(milliseconds(10'000));
  EXPECT_EQ(read_session_state(work.path()).pending.size(), 1u);
}

/// A heartbeat under another recorder, which took over the node of "drive".
class AnotherRecorder : public OperatingTest, public ::testing::WithParamInterface<std::int64_t> {
 protected:
  AnotherRecorder() {
    owner = GetParam();
    options.recorder.on_warning = [this](const std::string& sentence) { warnings.push_back(sentence); };
  }
  const std::vector<std::string> left{
      "node 2 obeys another recorder: the rest of \"drive\" is left to that one"};
  std::vector<std::string> warnings;
};
// It began while "drive" was recorded by others, or later.
INSTANTIATE_TEST_SUITE_P(Began, AnotherRecorder, ::testing::Values(kBefore + 70, kBefore + 5000));

// A claim would wait for the moment in which that recorder is held, and stop the node.
TEST_P(AnotherRecorder, KeepsTheNodeThatARecordingThatIsOverHadARestAt) {
  state.pending = {{"drive", 2, 77}};
  write_session_state(work.path(), state);
  operate();
  run(milliseconds(60'000));
  EXPECT_TRUE(begun.empty());
  EXPECT_EQ(warnings, left);
  EXPECT_TRUE(read_session_state(work.path()).pending.empty());
}

TEST_P(AnotherRecorder, KeepsTheNodeOfWhichNoRestIsKnown) {
  operate();
  run(milliseconds(60'000));
  EXPECT_TRUE(begun.empty());
  EXPECT_EQ(warnings, std::vector<std::string>{});
}

// Else it would not be recorded when that recorder is gone for good.
TEST_P(AnotherRecorder, LeavesTheNodeToTheNextRecordingWhenItIsGone) {
  options.start = "next";
  operate();
  ASSERT_EQ(begun.size(), 1u);
  EXPECT_FALSE(begun[0].scope.is_former(owner));
  EXPECT_TRUE(begun[0].scope.has({2, 77}));
}

// The recorder was started anew meanwhile.
TEST_F(OperatingTest, ANodeThatObeysASessionThatWasFetchingItsRestIsFetched) {
  state.pending = {{"drive", 2, 77}};
  write_session_state(work.path(), state);
  for (const std::int64_t session : {kBefore + 7000, kBefore + 8000})
    keep_incarnation(work.path() / "drive", session);
  owner = kBefore + 7000;
  operate();
  run(milliseconds(1000));
  ASSERT_EQ(begun.size(), 1u);
  EXPECT_EQ(begun[0].folder.filename(), "drive");
  EXPECT_EQ(begun[0].scope.only, (std::vector<NodeEpoch>{{2, 77}}));
}

TEST_F(OperatingTest, ANodeThatObeysARecorderWhoseNumberIsInTheFallbackIsFetched) {
  options.recorder.fallback = work.path() / "fallback";
  std::filesystem::create_directories(options.recorder.fallback / "drive");
  keep_incarnation(options.recorder.fallback / "drive", kBefore + 7000);
  state.pending = {{"drive", 2, 77}};
  write_session_state(work.path(), state);
  owner = kBefore + 7000;
  operate();
  run(milliseconds(1000));
  EXPECT_EQ(begun.size(), 1u);
}

}  // namespace
}  // namespace roadbalance
