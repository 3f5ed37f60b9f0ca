#include "host/recorder/node_control.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
constexpr WallTime kStart{std::chrono::hours(1)};

Heartbeat beat(NodeState state, std::int64_t owner) {
  return {.node = 2, .epoch = 8, .state = state, .owner = owner};
}

class NodeControlTest : public ::testing::Test {
 protected:
  std::optional<Command> due(WallTime at) {
    const auto commands = control.due(at);
    return commands.empty() ? std::nullopt : std::optional(commands.front());
  }
  void answer(const Command& command, CommandError result) {
    control.take(Reply{.node = 2, .epoch = 8, .request = command.request, .result = result, .sequence = 1});
  }

  NodeControl control{50, true, 1};
};

TEST_F(NodeControlTest, ClaimsThenStartsThenStops) {
  control.take(beat(NodeState::kPreview, 0));
  const auto claim = due(kStart);
  ASSERT_TRUE(claim);
  EXPECT_EQ(claim->verb, Verb::kClaim);
  EXPECT_EQ(claim->incarnation, 50);
  answer(*claim, CommandError::kNone);
  const auto start = due(kStart);
  ASSERT_TRUE(start);
  EXPECT_EQ(start->verb, Verb::kStart);
  control.take(beat(NodeState::kStarted, 50));
  EXPECT_FALSE(due(kStart + 1s));
  control.stop();
  const auto stop = due(kStart + 1s);
  ASSERT_TRUE(stop);
  EXPECT_EQ(stop->verb, Verb::kStop);
  control.take(beat(NodeState::kEnded, 50));
  EXPECT_FALSE(due(kStart + 3s));
}

TEST_F(NodeControlTest, RepeatsTheSameRequestUntilItIsAnswered) {
  control.take(beat(NodeState::kPreview, 0));
  const auto first = due(kStart);
  EXPECT_FALSE(due(kStart + 5ms));
  const auto second = due(kStart + 150ms);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->request, second->request);
}

// Each command names the same instant, whenever it is sent, and is repeated until that is over.
TEST_F(NodeControlTest, AnnouncesOneStartAndOneStop) {
  const std::int64_t notice_us = std::chrono::microseconds(NodeControl::notice_for(1)).count();
  control.take(beat(NodeState::kPreview, 0));
  answer(*due(kStart), CommandError::kNone);
  std::int64_t starts = 0;
  for (WallTime now = kStart; now < kStart + 100ms; now += 1ms)
    if (const auto start = due(now)) {
      ++starts;
      EXPECT_EQ(start->delay_us, notice_us - (now - kStart) / 1us);
      answer(*start, CommandError::kNone);
    }
  EXPECT_GE(starts, 4);
  Heartbeat second = beat(NodeState::kPreview, 50);
  second.node = 3;
  control.take(second);
  EXPECT_EQ(control.due(kStart + 100ms).back().delay_us, 60'000)
      << "it cannot have heard of the common start in time";
  Heartbeat measures = beat(NodeState::kStarted, 50);
  control.take(measures);
  measures.node = 3;
  control.take(measures);
  EXPECT_FALSE(due(kStart + 1s));
  control.stop();
  const auto stops = control.due(kStart + 1s);
  ASSERT_EQ(stops.size(), 2u);
  EXPECT_GT(stops[0].delay_us, 0);
  EXPECT_EQ(stops[0].delay_us, stops[1].delay_us);
  EXPECT_EQ(control.due(kStart + 1s + 300ms)[0].delay_us, stops[0].delay_us - 300'000);
}

// Its claim or its answer was lost: it knows by the delay what it misses.
TEST_F(NodeControlTest, TellsANodeThatHearsOfTheStartLateWhenThatWas) {
  control.take(beat(NodeState::kPreview, 0));
  ASSERT_TRUE(due(kStart));
  control.take(beat(NodeState::kPreview, 50));
  const auto start = due(kStart + 1s);
  ASSERT_TRUE(start);
  EXPECT_EQ(start->delay_us, std::chrono::microseconds(NodeControl::notice_for(1) - 1s).count());
}

TEST(NodeControlNotice, GrowsWithTheNodes) {
  EXPECT_LT(NodeControl::notice_for(4), 200ms) << "a start of four is answered in 300 ms";
  EXPECT_LT(NodeControl::notice_for(48), 700ms) << "of 48 in a second";
  EXPECT_GT(NodeControl::notice_for(48), NodeControl::notice_for(16));
}

// A node remembers its answers by request: the same one would be refused for ever.
TEST_F(NodeControlTest, AsksAnewAfterARefusal) {
  control.take(beat(NodeState::kPreview, 49));
  const auto first = due(kStart);
  ASSERT_TRUE(first);
  answer(*first, CommandError::kNotOwner);
  EXPECT_FALSE(due(kStart + 5ms));
  const auto second = due(kStart + 150ms);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->verb, Verb::kClaim);
  EXPECT_NE(first->request, second->request);
}

TEST_F(NodeControlTest, SeesThatANodeObeysAHigherIncarnation) {
  control.take(beat(NodeState::kPreview, 60));
  EXPECT_EQ(control.obeyed_higher(), 60);
  control.set_incarnation(61);
  EXPECT_EQ(control.obeyed_higher(), 0);
  EXPECT_EQ(due(kStart)->incarnation, 61);
}

// One datagram must not take away the numbers of all recorders to come.
TEST_F(NodeControlTest, IsNotDrivenToTheLastIncarnationThereIs) {
  control.take(beat(NodeState::kPreview, kIndexLimit));
  EXPECT_EQ(control.obeyed_higher(), 0);
}

// After a release no recorder owns the node, and it obeys no incarnation below the one it had.
TEST_F(NodeControlTest, LearnsFromARefusalWhichIncarnationTheNodeObeyed) {
  control.take(beat(NodeState::kPreview, 0));
  const auto claim = due(kStart);
  ASSERT_TRUE(claim);
  control.take(Reply{
      .node = 2, .epoch = 8, .request = claim->request, .result = CommandError::kNotOwner, .sequence = 60});
  EXPECT_EQ(control.obeyed_higher(), 60);
}

TEST_F(NodeControlTest, LeadsTwoNodesWithOneNumberApart) {
  Heartbeat other = beat(NodeState::kPreview, 0);
  other.epoch = 9;
  control.take(beat(NodeState::kPreview, 0));
  control.take(other);
  const auto claims = control.due(kStart);
  ASSERT_EQ(claims.size(), 2u);
  EXPECT_NE(claims[0].request, claims[1].request);
  answer(claims[0], CommandError::kNone);
  const auto next = control.due(kStart + 200ms);
  ASSERT_EQ(next.size(), 2u);
  EXPECT_EQ(next[0].verb, Verb::kStart);
  EXPECT_EQ(next[1].verb, Verb::kClaim) << "the other one has not answered";
  EXPECT_EQ(next[1].request, claims[1].request);
  EXPECT_TRUE(control.was_started(2, 8));
  EXPECT_FALSE(control.was_started(2, 9));
}

TEST_F(NodeControlTest, TellsASilentEpochNothingUntilItIsHeardAgain) {
  control.take(beat(NodeState::kPreview, 0));
  ASSERT_TRUE(due(kStart));
  EXPECT_TRUE(due(kStart + 2s));
  EXPECT_FALSE(due(kStart + 4s));
  control.take(beat(NodeState::kPreview, 0));
  EXPECT_TRUE(due(kStart + 60s));
}

TEST_F(NodeControlTest, ForgetsTheLongestSilentOfTooManyEpochs) {
  for (std::int64_t epoch = 1; epoch <= 10'000; ++epoch) {
    Heartbeat any = beat(NodeState::kPreview, 0);
    any.epoch = epoch;
    control.take(any);
  }
  EXPECT_EQ(control.due(kStart).size(), NodeControl::kMostEpochs);
}

TEST_F(NodeControlTest, StopsANodeWhoseStartMayBeUnderWay) {
  control.take(beat(NodeState::kPreview, 50));
  ASSERT_EQ(due(kStart)->verb, Verb::kStart);
  control.stop();
  ASSERT_EQ(due(kStart + 200ms)->verb, Verb::kStop);
}

// An answer does not tell what it holds for the recorder before, which died.
TEST(NodeControlOfARest, AsksANodeUntilItIsHeardToObey) {
  NodeControl control{50, true, 1};
  control.stop();
  control.take(beat(NodeState::kStarted, 49));
  const auto claim = control.due(kStart);
  ASSERT_EQ(claim.size(), 1u);
  control.take(Reply{claim[0].node, claim[0].epoch, claim[0].request});
  EXPECT_TRUE(control.is_asking(kStart));
  control.take(beat(NodeState::kStarted, 50));
  EXPECT_FALSE(control.is_asking(kStart));
}

// Its start never came, and the recording that it was for is over: in a new epoch it can join the next one.
TEST(NodeControlOfARest, StopsANodeInPreviewAndWaitsForItsEnd) {
  NodeControl control{50, false, 1, true};
  control.stop();
  control.take(beat(NodeState::kPreview, 0));
  (void)control.due(kStart);
  EXPECT_TRUE(control.is_asking(kStart)) << "it is not over before the node has answered";
  control.take(beat(NodeState::kPreview, 50));
  const auto stop = control.due(kStart + 1s);
  ASSERT_EQ(stop.size(), 1u);
  EXPECT_EQ(stop[0].verb, Verb::kStop);
  EXPECT_TRUE(control.was_started(2, 8)) << "its end is to be waited for";
  control.take(beat(NodeState::kEnded, 50));
  EXPECT_TRUE(control.due(kStart + 2s).empty());
}

TEST_F(NodeControlTest, LeavesANodeInPreviewThatNoRestIsOf) {
  NodeControl leaving{50, false, 1};
  leaving.stop();
  leaving.take(beat(NodeState::kPreview, 50));
  EXPECT_TRUE(leaving.due(kStart).empty());
  EXPECT_FALSE(leaving.was_started(2, 8));
}

TEST_F(NodeControlTest, DoesNotWaitForTheEndOfANodeThatOnlyObeyedAnother) {
  control.take(beat(NodeState::kStarted, 49));
  EXPECT_FALSE(control.was_started(2, 8)) << "an observer told to end would never end";
  control.take(beat(NodeState::kStarted, 50));
  EXPECT_TRUE(control.was_started(2, 8));
  control.take(beat(NodeState::kStarted, 49));
  EXPECT_TRUE(control.was_started(2, 8));
}

}  // namespace
}  // namespace roadbalance
