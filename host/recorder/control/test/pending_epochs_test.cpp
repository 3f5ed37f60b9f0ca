#include "host/recorder/control/pending_epochs.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A session that the test leads.
struct Script {
  bool lives = false, stopped = false;
  Session::View view{};
};
class ScriptedSession final : public Session {
 public:
  explicit ScriptedSession(Script& script) : script_(script) { script_ = {.lives = true}; }
  ~ScriptedSession() override { script_.lives = false; }
  void stop(const std::string&) override { script_.stopped = true; }
  void note(NoteToRecord) override {}
  View view() const override { return script_.view; }

 private:
  Script& script_;
};

class PendingEpochsTest : public ::testing::Test {
 protected:
  void hear(std::int32_t node, std::int64_t epoch, std::int64_t owner = 0) {
    fetching.take({.node = node, .epoch = epoch, .owner = owner}, now);
  }
  std::optional<PendingEpochs::Outcome> turn() { return fetching.turn(pending, now); }
  /// Heard ten times a second.
  void hear_for(seconds time, std::int32_t node, std::int64_t epoch, std::int64_t owner = 0) {
    for (const WallTime end = now + time; now < end; now += milliseconds(100)) hear(node, epoch, owner);
  }
  void over(std::vector<NodeReport> node, std::string error = "") {
    script.view.report.node = std::move(node);
    script.view.error = std::move(error);
    script.view.is_over = true;
  }

  WallTime now{std::chrono::hours(1)};
  std::vector<PendingEpoch> pending{{"drive", 2, 77}, {"drive", 3, 88}, {"later", 2, 99}};
  Script script;
  std::string begun;
  EpochScope scope;
  std::int64_t anothers = 1000;  ///< and higher incarnations
  PendingEpochs fetching{
      [this](const std::string& recording, EpochScope of) {
        begun = recording;
        scope = std::move(of);
        return std::make_unique<ScriptedSession>(script);
      },
      [this](const std::string&, std::int64_t incarnation) { return incarnation < anothers; }};
};

TEST_F(PendingEpochsTest, WaitsForTheNodeAndFetchesOnlyWhatIsBack) {
  hear_for(seconds(30), 1, 5);
  EXPECT_FALSE(turn());
  EXPECT_FALSE(script.lives);
  hear(2, 77);
  EXPECT_FALSE(turn());
  ASSERT_TRUE(script.lives);
  EXPECT_TRUE(script.stopped) << "the node is to end at once";
  EXPECT_EQ(begun, "drive");
  EXPECT_EQ(fetching.under_way(), "drive");
  EXPECT_EQ(scope.only, (std::vector<NodeEpoch>{{2, 77}}));
  EXPECT_TRUE(scope.given_up.empty());
  EXPECT_TRUE(scope.leaves_open);
  over({{.node = 2, .epoch = 77, .blocks = 100, .ended = true, .sums_agree = true}});
  const auto outcome = turn();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->settled, (std::vector<PendingEpoch>{{"drive", 2, 77}}));
  EXPECT_TRUE(outcome->lost.empty());
  EXPECT_FALSE(script.lives);
}

TEST_F(PendingEpochsTest, WhatIsCutOffAgainOrFailsStaysAndIsTriedAgainLater) {
  hear(2, 77);
  (void)turn();
  over({{.node = 2, .epoch = 77, .blocks = 100, .started = true}});
  EXPECT_TRUE(turn()->settled.empty());
  begun.clear();
  hear(2, 77);
  (void)turn();
  EXPECT_EQ(begun, "") << "not at once";
  hear_for(seconds(5), 2, 77);
  (void)turn();
  EXPECT_EQ(begun, "drive");
  over({{.node = 2, .epoch = 77, .blocks = 200, .ended = true}}, "the disk is full");
  const auto outcome = turn();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->error, "the disk is full");
  EXPECT_TRUE(outcome->settled.empty()) << "nobody knows what is on the disk";
}

// One that cannot be had must not keep the others waiting.
TEST_F(PendingEpochsTest, TakesTurnsBetweenRecordings) {
  const auto hear_both = [&] {
    for (int k = 0; k < 60; ++k, now += milliseconds(100)) {
      hear(2, 77);
      hear(2, 99);
    }
  };
  std::vector<std::string> all;
  for (int k = 0; k < 4; ++k) {
    hear_both();
    (void)turn();
    all.push_back(begun);
    over({}, "it fails");
    (void)turn();
  }
  EXPECT_EQ(std::ranges::count(all, "drive"), 2);
  EXPECT_EQ(std::ranges::count(all, "later"), 2);
}

TEST_F(PendingEpochsTest, ANodeThatWasStartedAnewHasLostItsRestAndItIsSaid) {
  pending = {{"drive", 2, 77}};
  hear_for(seconds(10), 2, 78);
  now -= milliseconds(100);  // the last heartbeat is 10 s - 100 ms behind the first
  (void)turn();
  EXPECT_FALSE(script.lives) << "it may be two nodes of one number";
  now += milliseconds(100);
  hear(2, 78);
  (void)turn();
  ASSERT_TRUE(script.lives);
  EXPECT_EQ(scope.given_up, (std::vector<NodeEpoch>{{2, 77}}));
  over({});
  script.view.report.earlier = {{.node = 2, .epoch = 77, .blocks = 100, .ended = true, .crashed = true}};
  const auto outcome = turn();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->settled, pending);
  EXPECT_EQ(outcome->lost, pending);
}

// The recorder was killed behind the last sync and before the session state: the node has ended and begun
// anew.
TEST_F(PendingEpochsTest, WhatTheRecordHasAlreadyIsSettledAndNotLost) {
  pending = {{"drive", 2, 77}};
  hear_for(seconds(11), 2, 78);
  (void)turn();
  ASSERT_TRUE(script.lives);
  over({});
  script.view.report.earlier = {{.node = 2, .epoch = 77, .blocks = 100, .ended = true, .sums_agree = true}};
  const auto outcome = turn();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->settled, pending);
  EXPECT_TRUE(outcome->lost.empty());
}

TEST_F(PendingEpochsTest, TheOldEpochOfTwoNodesWithOneNumberIsNotGivenUpWhileItIsHeard) {
  pending = {{"drive", 2, 77}};
  for (int k = 0; k < 200; ++k, now += milliseconds(100)) {
    hear(2, 78);
    if (k % 50 == 0) hear(2, 77);
  }
  (void)turn();
  EXPECT_FALSE(script.lives && !scope.given_up.empty());
}

TEST_F(PendingEpochsTest, ANodeThatNeverGotTheStartHoldsNothing) {
  hear(3, 88);
  (void)turn();
  over({{.node = 3, .epoch = 88}});
  EXPECT_EQ(turn()->settled, (std::vector<PendingEpoch>{{"drive", 3, 88}}));
}

// The session did not hear it: it may not know that its end is on the disk, and so holds its last blocks.
TEST_F(PendingEpochsTest, AnEndOnTheDiskIsNotEnoughUnlessTheNodeHasLetGo) {
  pending = {{"drive", 2, 77}};
  hear(2, 77);
  (void)turn();
  over({});
  script.view.report.earlier = {{.node = 2, .epoch = 77, .blocks = 100, .ended = true, .sums_agree = true}};
  EXPECT_TRUE(turn()->settled.empty());
  hear_for(seconds(6), 2, 77);
  (void)turn();
  over({{.node = 2, .epoch = 77, .blocks = 100, .ended = true, .started = true, .holds_blocks = true}});
  EXPECT_TRUE(turn()->settled.empty());
  hear_for(seconds(6), 2, 77);
  (void)turn();
  over({{.node = 2, .epoch = 77, .blocks = 100, .ended = true, .started = true}});
  EXPECT_EQ(turn()->settled, pending);
}

TEST_F(PendingEpochsTest, WhatObeysAnotherRecorderIsNotFetchedAndTheOthersAre) {
  hear(2, 77, anothers);
  hear(3, 88, 150);
  (void)turn();
  ASSERT_TRUE(script.lives);
  EXPECT_EQ(scope.only, (std::vector<NodeEpoch>{{3, 88}}));
}

// Its claim is refused as long as that recorder is heard by the node, and would be granted when it is held.
TEST_F(PendingEpochsTest, ASessionWhoseNodeAnotherRecorderHasTakenIsLeftAndTheRestOfItTriedAgain) {
  hear(2, 77, 150);
  hear(3, 88, 150);
  (void)turn();
  ASSERT_TRUE(script.lives);
  hear(2, 77, anothers);
  EXPECT_FALSE(turn());
  EXPECT_FALSE(script.lives);
  EXPECT_EQ(fetching.under_way(), "");
  for (int k = 0; k < 50; ++k, now += milliseconds(100)) {
    hear(2, 77, anothers);
    hear(3, 88, 150);
  }
  (void)turn();
  ASSERT_TRUE(script.lives);
  EXPECT_EQ(scope.only, (std::vector<NodeEpoch>{{3, 88}}));
}

TEST_F(PendingEpochsTest, ARestIsTakenOverWhenItsNodeHasObeyedAnotherRecorderForThreeSeconds) {
  pending = {{"drive", 2, 77}};
  hear_for(seconds(3), 2, 77, 150);
  hear(2, 77, anothers);  // from long ago
  hear_for(seconds(3), 2, 77, 150);
  EXPECT_TRUE(fetching.taken_over(pending, now).empty());
  hear_for(seconds(3), 2, 77, anothers);
  EXPECT_TRUE(fetching.taken_over(pending, now).empty()) << "the last one is 3 s - 100 ms behind the first";
  hear(2, 77, anothers);
  EXPECT_EQ(fetching.taken_over(pending, now), pending);
  now += seconds(2);
  EXPECT_TRUE(fetching.taken_over(pending, now).empty()) << "it is not heard now";
}

class UnknownPending : public PendingEpochsTest {
 protected:
  void hear_for_2s(Heartbeat beat) {
    for (int k = 0; k < 20; ++k, now += milliseconds(100)) fetching.take(beat, now);
  }
  std::vector<PendingEpoch> unknown() { return fetching.unknown(recorded, {}, now); }

  const std::vector<PastRecording> recorded{{"drive", 100, 200}, {"later", 300, 400}};
};

// Started by a recorder that was killed before anything was on the disk, and cut off until all was over.
TEST_F(UnknownPending, AreWhatTheirOwnersIncarnationSays) {
  const Heartbeat measures{
      .node = 2, .epoch = 77, .base = 1, .next = 9, .state = NodeState::kStarted, .owner = 150};
  fetching.take(measures, now);
  EXPECT_TRUE(unknown().empty()) << "a heartbeat may be late";
  hear_for_2s(measures);
  EXPECT_EQ(unknown(), (std::vector<PendingEpoch>{{"drive", 2, 77}}));
  EXPECT_TRUE(fetching.unknown(recorded, {{"drive", 2, 77}}, now).empty()) << "known";
  now += seconds(2);
  EXPECT_TRUE(unknown().empty()) << "it is cut off again";
  hear_for_2s({.node = 3, .epoch = 88, .base = 7, .next = 9, .state = NodeState::kEnded, .owner = 400});
  EXPECT_EQ(unknown(), (std::vector<PendingEpoch>{{"later", 3, 88}}));
}

TEST_F(UnknownPending, AreNoPreviewsNoOthersAndNothingThatIsEmpty) {
  hear_for_2s({.node = 2, .epoch = 77, .state = NodeState::kPreview, .owner = 150});
  EXPECT_TRUE(unknown().empty());
  hear_for_2s({.node = 3, .epoch = 88, .base = 9, .next = 9, .state = NodeState::kEnded, .owner = 150});
  EXPECT_TRUE(unknown().empty());
  hear_for_2s({.node = 4, .epoch = 99, .base = 1, .next = 9, .state = NodeState::kStarted, .owner = 250});
  EXPECT_TRUE(unknown().empty()) << "of another recorder";
}

TEST_F(UnknownPending, AreNotThoseOfARecorderThatBeganBetweenTwoOfTheRecording) {
  anothers = 150;
  hear_for_2s({.node = 2, .epoch = 77, .base = 1, .next = 9, .state = NodeState::kStarted, .owner = 150});
  hear_for_2s({.node = 3, .epoch = 88, .base = 1, .next = 9, .state = NodeState::kStarted, .owner = 149});
  EXPECT_EQ(unknown(), (std::vector<PendingEpoch>{{"drive", 3, 88}}));
}

// Otherwise one whose crash was declared and that lives all the same would be fetched again and again.
TEST_F(UnknownPending, AreNotThoseThatWereSettled) {
  pending = {{"drive", 2, 77}};
  hear_for_2s({.node = 2, .epoch = 77, .base = 1, .next = 9, .state = NodeState::kStarted, .owner = 150});
  (void)turn();
  over({});
  script.view.report.earlier = {{.node = 2, .epoch = 77, .blocks = 9, .ended = true, .crashed = true}};
  EXPECT_EQ(turn()->settled, pending);
  EXPECT_TRUE(unknown().empty());
}

TEST(PendingOf, AreEpochsWithoutAnEndThatMayHoldSomething) {
  RecorderReport report;
  report.earlier = {{.node = 1, .epoch = 1, .blocks = 9},
                    {.node = 1, .epoch = 2, .blocks = 9, .ended = true},
                    // Not heard since its end was written, nor is its node: it may not know.
                    {.node = 4, .epoch = 7, .blocks = 9, .ended = true},
                    {.node = 5, .epoch = 8, .blocks = 9, .ended = true, .crashed = true}};
  report.node = {{.node = 1, .epoch = 3},
                 {.node = 1, .epoch = 4, .started = true},
                 {.node = 2, .epoch = 5, .samples_sent = 20},
                 {.node = 3, .epoch = 6, .blocks = 9, .ended = true, .started = true},
                 {.node = 3, .epoch = 9, .blocks = 9, .ended = true, .started = true, .holds_blocks = true}};
  const std::vector<PendingEpoch> expected{
      {"drive", 1, 1}, {"drive", 4, 7}, {"drive", 1, 4}, {"drive", 2, 5}, {"drive", 3, 9}};
  EXPECT_EQ(pending_of(report, "drive"), expected);
}

}  // namespace
}  // namespace roadbalance
