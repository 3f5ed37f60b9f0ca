#include "host/recorder/node_presence.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::int64_t kUtc_us = 1'769'860'800'000'000;

// Heartbeats of nodes that live, and turns, ten times a second.
class NodePresenceTest : public ::testing::Test {
 protected:
  static Heartbeat beat(std::int32_t node, NodeState state = NodeState::kStarted,
                        AbsenceCause cause = AbsenceCause::kNone, std::int64_t epoch = 0) {
    return {.node = node, .epoch = epoch == 0 ? 10 * node : epoch, .state = state, .end_cause = cause};
  }
  static Heartbeat ended(std::int32_t node, AbsenceCause cause) {
    return beat(node, NodeState::kEnded, cause);
  }

  void run(milliseconds time, const std::vector<Heartbeat>& beats) {
    for (const WallTime end = now + time; now < end; now += milliseconds(100)) {
      for (const Heartbeat& one : beats) presence.take(one, now);
      presence.turn(now, notes);
    }
  }
  /// "24 2 4": kind, node, b.
  std::vector<std::string> noted() const {
    std::vector<std::string> all;
    for (const NoteToRecord& note : notes)
      all.push_back(std::to_string(static_cast<int>(note.kind)) + " " + std::to_string(note.a) + " " +
                    std::to_string(note.b));
    return all;
  }
  std::vector<std::string> absences() const {
    std::vector<std::string> all;
    for (const Absence& absence : presence.absences(now, kUtc_us))
      all.push_back(std::to_string(absence.node) + " " + words(absence));
    return all;
  }
  using Words = std::vector<std::string>;
  static constexpr const char* kProgramEnded =
      "its program was ended: by its service, a person or a closed terminal";

  WallTime now{seconds(1000)};
  std::vector<NoteToRecord> notes;
  NodePresence presence{{.expected = {{1, "front"}, {2, "rear"}}}, {}};
};

TEST_F(NodePresenceTest, MissesNobodyWhoMeasuresFromStartToStop) {
  run(seconds(20), {beat(1), beat(2)});
  presence.stop(now);
  run(seconds(20), {ended(1, AbsenceCause::kStopped)});
  EXPECT_EQ(noted(), Words());
  EXPECT_EQ(absences(), Words());
}

TEST_F(NodePresenceTest, MissesWhoNeverCame) {
  run(milliseconds(3200), {beat(1)});
  EXPECT_EQ(noted(), (Words{"24 2 6"}));
  EXPECT_EQ(notes.front().text, "rear");
  ASSERT_EQ(presence.absent(), (std::vector<AbsentNode>{{2, AbsenceCause::kNeverCame}}));
  presence.stop(now);
  EXPECT_EQ(absences(), (Words{"2 never came"}));
}

TEST_F(NodePresenceTest, MissesAtOnceWhoIsKnownToBeMissing) {
  NodePresence partial({.expected = {{1, "front"}, {2, "rear", true}}}, {});
  partial.turn(now, notes);
  EXPECT_EQ(noted(), (Words{"24 2 6"}));
  EXPECT_EQ(partial.absent().size(), 1u);
}

TEST_F(NodePresenceTest, MissesNobodyWhoObeysAnotherRecorder) {
  for (int k = 0; k < 100; ++k) {
    presence.take_foreign(2, now);
    run(milliseconds(100), {beat(1)});
  }
  EXPECT_EQ(noted(), Words());
}

TEST_F(NodePresenceTest, WhoIsStoppedByUsBehindASilenceLacksNothing) {
  run(seconds(5), {beat(1), beat(2)});
  run(seconds(5), {beat(1)});
  presence.stop(now);
  run(seconds(1), {ended(2, AbsenceCause::kStopped)});
  EXPECT_EQ(noted(), (Words{"24 2 5", "25 2 0"}));
  EXPECT_EQ(absences(), Words());
}

TEST_F(NodePresenceTest, WhoHadEndedBehindASilenceIsMissedThoughTheStopCameBetween) {
  run(seconds(5), {beat(1), beat(2)});
  run(seconds(5), {beat(1)});
  presence.stop(now);
  run(seconds(1), {ended(2, AbsenceCause::kDeviceFailed)});
  EXPECT_EQ(noted(), (Words{"24 2 5", "24 2 3"}));
  EXPECT_EQ(absences(),
            (Words{"2 ended 5.1 s before the recording: its device failed: look at its cable and supply"}));
}

TEST_F(NodePresenceTest, SaysWhoCameLate) {
  run(seconds(20), {beat(1)});
  run(seconds(5), {beat(1), beat(2)});
  presence.stop(now);
  EXPECT_EQ(noted(), (Words{"24 2 6", "25 2 1"}));
  EXPECT_EQ(absences(), (Words{"2 came 20 s late"}));
  EXPECT_TRUE(presence.absent().empty());
}

TEST_F(NodePresenceTest, SaysWhyANodeEnded) {
  run(seconds(5), {beat(1), beat(2)});
  run(milliseconds(1200), {beat(1), ended(2, AbsenceCause::kProgramEnded)});
  EXPECT_EQ(noted(), (Words{"24 2 4"})) << "within three seconds";
  EXPECT_EQ(presence.absent(), (std::vector<AbsentNode>{{2, AbsenceCause::kProgramEnded}}));
  run(seconds(37), {beat(1)});
  presence.stop(now);
  run(seconds(60), {});
  EXPECT_EQ(absences(), (Words{std::string("2 ended 38 s before the recording: ") + kProgramEnded}));
}

TEST_F(NodePresenceTest, EndsWithWhoEndsEverythingAtOnce) {
  run(seconds(5), {beat(1), beat(2)});
  run(milliseconds(200), {beat(1), ended(2, AbsenceCause::kProgramEnded)});
  presence.stop(now, NodePresence::Stop::kBySignal);
  run(seconds(5), {ended(1, AbsenceCause::kProgramEnded)});
  EXPECT_EQ(noted(), Words());
}

TEST_F(NodePresenceTest, WhoEndsWellBeforeASignalEndsTheRecorderIsMissed) {
  run(seconds(5), {beat(1), beat(2)});
  run(milliseconds(400), {beat(1), ended(2, AbsenceCause::kProgramEnded)});
  presence.stop(now, NodePresence::Stop::kBySignal);
  EXPECT_EQ(absences(), (Words{std::string("2 ended 0.4 s before the recording: ") + kProgramEnded}));
}

TEST_F(NodePresenceTest, ADeviceThatFailsAMomentBeforeASignalIsMissed) {
  run(seconds(5), {beat(1), beat(2)});
  run(milliseconds(100), {beat(1), ended(2, AbsenceCause::kDeviceFailed)});
  presence.stop(now, NodePresence::Stop::kBySignal);
  run(milliseconds(100), {});
  EXPECT_EQ(noted(), (Words{"24 2 3"}));
}

TEST_F(NodePresenceTest, WhoEndsAMomentBeforeAStopThatIsAskedForIsMissed) {
  run(seconds(5), {beat(1), beat(2)});
  run(milliseconds(100), {beat(1), ended(2, AbsenceCause::kProgramEnded)});
  EXPECT_EQ(noted(), Words());
  presence.stop(now);
  run(seconds(5), {ended(1, AbsenceCause::kStopped), ended(2, AbsenceCause::kProgramEnded)});
  EXPECT_EQ(noted(), (Words{"24 2 4"}));
  EXPECT_EQ(absences(), (Words{std::string("2 ended 0.1 s before the recording: ") + kProgramEnded}));
}

TEST_F(NodePresenceTest, AnEarlyEndThatIsHeardBehindTheStopIsMissed) {
  run(seconds(5), {beat(1), beat(2)});
  presence.stop(now);
  run(seconds(5), {ended(1, AbsenceCause::kStopped), ended(2, AbsenceCause::kProgramEnded)});
  EXPECT_EQ(noted(), (Words{"24 2 4"}));
  EXPECT_EQ(absences(), (Words{std::string("2 ended 0.0 s before the recording: ") + kProgramEnded}));
}

// It has not heard the stop perhaps, and has measured beyond it.
TEST_F(NodePresenceTest, AnEndBehindTheStopOfWhoWasCutOffForAMomentSaysNothing) {
  run(seconds(5), {beat(1), beat(2)});
  run(milliseconds(1500), {beat(1)});
  presence.stop(now);
  run(milliseconds(500), {ended(2, AbsenceCause::kProgramEnded)});
  EXPECT_EQ(noted(), Words());
}

TEST_F(NodePresenceTest, MissesWhoNeverCameHoweverShortTheRecordingIs) {
  run(milliseconds(1000), {beat(1)});
  presence.stop(now);
  run(milliseconds(500), {ended(1, AbsenceCause::kStopped)});
  EXPECT_EQ(noted(), Words()) << "it may be heard yet";
  presence.finish(now);
  presence.turn(now, notes);
  EXPECT_EQ(noted(), (Words{"24 2 6"}));
  EXPECT_EQ(absences(), (Words{"2 never came"}));
  EXPECT_EQ(presence.absences(now, kUtc_us).front().seconds, 1.0);
}

TEST_F(NodePresenceTest, WhoIsHeardFirstBehindAnEarlyStopHasCome) {
  run(milliseconds(300), {});
  presence.stop(now);
  run(milliseconds(200), {beat(1)});
  run(milliseconds(500), {ended(1, AbsenceCause::kStopped), ended(2, AbsenceCause::kStopped)});
  presence.finish(now);
  presence.turn(now, notes);
  EXPECT_EQ(noted(), Words());
}

TEST_F(NodePresenceTest, WhoObeysAnotherRecorderIsNotMissedInTheEnd) {
  run(milliseconds(500), {beat(1)});
  presence.take_foreign(2, now);
  presence.stop(now);
  presence.finish(now);
  presence.turn(now, notes);
  EXPECT_EQ(noted(), Words());
}

TEST_F(NodePresenceTest, MissesNobodyWhoseSourceIsOver) {
  run(seconds(5), {beat(1), beat(2)});
  run(seconds(5), {beat(1), ended(2, AbsenceCause::kSourceOver)});
  run(seconds(5), {beat(1), beat(2, NodeState::kStarted, AbsenceCause::kNone, 77)});  // its next drive
  EXPECT_EQ(noted(), Words());
}

TEST_F(NodePresenceTest, ANodeThatIsOnlyCutOffLacksNothing) {
  run(seconds(5), {beat(1), beat(2)});
  run(seconds(10), {beat(1)});
  EXPECT_EQ(presence.absent(), (std::vector<AbsentNode>{{2, AbsenceCause::kSilent}}));
  run(seconds(5), {beat(1), beat(2)});
  presence.stop(now);
  EXPECT_EQ(noted(), (Words{"24 2 5", "25 2 0"}));
  EXPECT_EQ(absences(), Words());
}

TEST_F(NodePresenceTest, AnotherEpochIsOfANodeThatWasAway) {
  run(seconds(5), {beat(1), beat(2)});
  run(seconds(42), {beat(1)});
  run(seconds(5), {beat(1), beat(2, NodeState::kStarted, AbsenceCause::kNone, 77)});
  EXPECT_EQ(noted(), (Words{"24 2 5", "25 2 1"}));
  EXPECT_EQ(absences(), (Words{"2 was away for 42 s: its supply or its program failed"}));
}

TEST_F(NodePresenceTest, ARestartThatIsSoonOverIsAHole) {
  run(seconds(5), {beat(1), beat(2)});
  run(milliseconds(300), {beat(1), ended(2, AbsenceCause::kProgramEnded)});
  run(milliseconds(200), {beat(1), beat(2, NodeState::kPreview, AbsenceCause::kNone, 77)});
  run(seconds(5), {beat(1), beat(2, NodeState::kStarted, AbsenceCause::kNone, 77)});
  EXPECT_EQ(noted(), (Words{"24 2 4", "25 2 1"}));
  EXPECT_EQ(absences(), (Words{std::string("2 was away for 0.5 s: ") + kProgramEnded}));
}

TEST_F(NodePresenceTest, WhatHappenedReplacesThatItWasNotHeard) {
  run(seconds(5), {beat(1), beat(2)});
  run(seconds(10), {beat(1)});
  run(seconds(10), {beat(1), ended(2, AbsenceCause::kDeviceFailed)});
  presence.stop(now);
  EXPECT_EQ(noted(), (Words{"24 2 5", "24 2 3"}));
  EXPECT_EQ(absences(),
            (Words{"2 ended 20 s before the recording: its device failed: look at its cable and supply"}));
}

TEST_F(NodePresenceTest, AHeartbeatThatWasOvertakenByTheLastOneSaysNothing) {
  run(seconds(5), {beat(1), beat(2)});
  presence.take(ended(2, AbsenceCause::kProgramEnded), now);
  run(seconds(2), {beat(1), beat(2)});
  EXPECT_EQ(noted(), (Words{"24 2 4"}));
  presence.stop(now);
  presence.take(ended(1, AbsenceCause::kStopped), now);
  run(seconds(2), {beat(1)});
  EXPECT_EQ(notes.size(), 1u);
}

TEST_F(NodePresenceTest, TwoNodesOfOneNumberWriteNoNoteEachTime) {
  for (int k = 0; k < 100; ++k)
    run(milliseconds(100), {beat(1), beat(2), beat(2, NodeState::kStarted, AbsenceCause::kNone, 77)});
  EXPECT_EQ(noted(), Words());
}

TEST_F(NodePresenceTest, AKillAndARestartThatIsSoonOverAreAHole) {
  run(seconds(5), {beat(1), beat(2)});
  run(milliseconds(300), {beat(1)});
  run(seconds(5), {beat(1), beat(2, NodeState::kStarted, AbsenceCause::kNone, 77)});
  EXPECT_EQ(noted(), (Words{"24 2 5", "25 2 1"}));
  EXPECT_EQ(absences(), (Words{"2 was away for 0.4 s: its supply or its program failed"}));
}

TEST_F(NodePresenceTest, AComputerThatWasHeldMissesNobody) {
  run(seconds(5), {beat(1), beat(2)});
  now += seconds(30);
  presence.was_held(seconds(30));
  run(seconds(5), {beat(1), beat(2)});
  EXPECT_EQ(noted(), Words());
}

/// A recorder that is started again.
class NodePresenceAgain : public ::testing::Test {
 protected:
  void run(NodePresence& presence, milliseconds time, const std::vector<Heartbeat>& beats) {
    for (const WallTime end = now + time; now < end; now += milliseconds(100)) {
      presence.turn(now, notes);
      for (const Heartbeat& one : beats) presence.take(one, now);
    }
  }
  static Heartbeat beat(std::int32_t node, std::int64_t epoch) {
    return {.node = node, .epoch = epoch, .state = NodeState::kStarted};
  }
  WallTime now{seconds(9)};
  std::vector<NoteToRecord> notes;
};

TEST_F(NodePresenceAgain, MissesWhoIsInTheRecordAndDoesNotReturn) {
  RecordState recovered;
  recovered.epoch[{3, 30}].position.ended = false;
  recovered.epoch[{4, 40}].position.ended = true;
  NodePresence presence({.expected = {{4, "rear"}}}, recovered);
  run(presence, seconds(5), {});
  ASSERT_EQ(notes.size(), 1u) << "why epoch 40 ended was noted before";
  EXPECT_EQ(notes.front().a, 3);
  EXPECT_EQ(static_cast<AbsenceCause>(notes.front().b), AbsenceCause::kSilent);
}

TEST_F(NodePresenceAgain, ANodeMeasuresOnInWhicheverOfItsEpochsWasOpen) {
  RecordState recovered;
  recovered.epoch[{3, 30}].position.ended = false;
  recovered.epoch[{3, 31}].position.ended = false;
  NodePresence presence({}, recovered);
  run(presence, seconds(5), {beat(3, 30)});
  EXPECT_TRUE(notes.empty());
}

TEST_F(NodePresenceAgain, NotesThatANodeWhoseEpochHadEndedIsThereAgain) {
  RecordState recovered;
  recovered.epoch[{4, 40}].position.ended = true;
  NodePresence presence({}, recovered);
  run(presence, seconds(5), {beat(4, 41)});
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes.front().kind, NoteKind::kNodeThere);
  EXPECT_EQ(notes.front().b, 1);
}

// It was killed in the stop; the node ended as that had asked.
TEST_F(NodePresenceAgain, GoesOnWithAStopWithoutMissingWhoThatHadStopped) {
  RecordState recovered;
  recovered.epoch[{3, 30}].position.ended = false;
  NodePresence presence({.expected = {{3, "front"}}}, recovered);
  presence.turn(now, notes);
  presence.take({.node = 3, .epoch = 30, .state = NodeState::kEnded, .end_cause = AbsenceCause::kStopped},
                now);
  presence.turn(now, notes);
  now += milliseconds(100);
  presence.stop(now);
  presence.finish(now);
  presence.turn(now, notes);
  EXPECT_TRUE(notes.empty());
}

TEST_F(NodePresenceAgain, RemembersWhoWasAbsentBefore) {
  NodePresence presence(
      {.before = {{.node = 1, .cause = AbsenceCause::kProgramEnded, .since_us = kUtc_us, .seconds = 5},
                  {.node = 2,
                   .cause = AbsenceCause::kDeviceFailed,
                   .since_us = kUtc_us - 30'000'000,
                   .to_end = true}},
       .utc_us = kUtc_us},
      {});
  run(presence, seconds(10), {beat(1, 5)});
  EXPECT_TRUE(notes.empty()) << "they are in the record";
  ASSERT_EQ(presence.absent().size(), 1u);
  const auto absences = presence.absences(now, kUtc_us + 10'000'000);
  ASSERT_EQ(absences.size(), 2u);
  EXPECT_EQ(absences[0].seconds, 5.0);
  EXPECT_NEAR(absences[1].seconds, 40.0, 1e-6);
  run(presence, seconds(1), {beat(1, 5), beat(2, 6)});
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes.front().kind, NoteKind::kNodeThere);
}

TEST_F(NodePresenceAgain, WhereNodesEndTheRecordingOneThatEndsIsNotMissed) {
  NodePresence presence({.nodes_end_it = true}, {});
  presence.turn(now, notes);
  presence.take({.node = 1, .epoch = 5, .state = NodeState::kStarted}, now);
  presence.turn(now, notes);
  presence.take({.node = 1, .epoch = 5, .state = NodeState::kEnded, .end_cause = AbsenceCause::kProgramEnded},
                now);
  now += seconds(10);
  presence.turn(now, notes);
  EXPECT_TRUE(notes.empty());
}

}  // namespace
}  // namespace roadbalance
