#include "host/recorder/control/vehicle_push.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using State = VehiclePush::State;

const std::string kBefore(2500, 'b'), kAfter(3000, 'a');

Reply reply(const Command& to, CommandError result, std::string text = "") {
  return {.node = to.node,
          .epoch = 1,
          .request = to.request,
          .result = result,
          .sequence = 1,
          .text = std::move(text)};
}

struct VehiclePushTest : testing::Test {
  VehiclePush push{kBefore, kAfter, {1, 2}, 5, 1, WallTime{}};
};

TEST_F(VehiclePushTest, SaysAllPartsThenTheCommandUntilEachNodeHasAnswered) {
  const auto first = push.due(WallTime{});
  ASSERT_EQ(first.command.size(), 2u);
  ASSERT_EQ(first.part.size(), 6u);
  std::string text;
  for (std::size_t k = 0; k < 3; ++k) text += first.part[k].text;
  EXPECT_EQ(text, kAfter);
  EXPECT_TRUE(push.due(WallTime{} + milliseconds(299)).command.empty());
  push.take(reply(first.command[0], CommandError::kNone));
  const auto second = push.due(WallTime{} + VehiclePush::kRepeat);
  ASSERT_EQ(second.command.size(), 1u);
  EXPECT_EQ(second.command[0].node, 2);
  EXPECT_EQ(second.command[0].request, first.command[1].request) << "one request, which acts once";
  push.take(reply(second.command[0], CommandError::kVehicleMissing));
  EXPECT_EQ(push.state(), State::kUnderWay);
  push.take(reply(second.command[0], CommandError::kNone));
  EXPECT_EQ(push.state(), State::kDone);
}

TEST_F(VehiclePushTest, IfOneRefusesAllGetTheOldOneBack) {
  const auto first = push.due(WallTime{});
  push.take(reply(first.command[0], CommandError::kNone));
  push.take(reply(first.command[1], CommandError::kVehicleRefused, "no such range"));
  EXPECT_EQ(push.state(), State::kUnderWay);
  const auto undo = push.due(WallTime{} + milliseconds(1));
  ASSERT_EQ(undo.command.size(), 1u);
  EXPECT_EQ(undo.command[0].node, 1);
  EXPECT_NE(undo.command[0].request, first.command[0].request);
  EXPECT_EQ(undo.part[0].text[0], 'b');
  push.take(reply(undo.command[0], CommandError::kNone));
  EXPECT_EQ(push.state(), State::kRefused);
  EXPECT_EQ(push.why(), "node 2: no such range");
}

// All have it, and the recorder's disk does not take the file: each is asked to take the old one again.
TEST_F(VehiclePushTest, WhatIsDoneCanBeUndoneAtEachNode) {
  const auto first = push.due(WallTime{});
  push.undo("too soon");
  EXPECT_EQ(push.due(WallTime{} + VehiclePush::kRepeat).part[0].text[0], 'a') << "it is not done yet";
  for (const Command& command : first.command) push.take(reply(command, CommandError::kNone));
  ASSERT_EQ(push.state(), State::kDone);
  // Long after it was done: the patience with the nodes begins anew.
  const WallTime late = WallTime{} + 3 * VehiclePush::kPatience;
  push.undo("no space");
  EXPECT_EQ(push.state(), State::kUnderWay);
  const auto undo = push.due(late);
  ASSERT_EQ(undo.command.size(), 2u);
  EXPECT_EQ(undo.part[0].text[0], 'b');
  for (const Command& command : undo.command) EXPECT_NE(command.request, first.command[0].request);
  push.take(reply(undo.command[0], CommandError::kNone));
  EXPECT_EQ(push.state(), State::kUnderWay);
  EXPECT_TRUE(push.due(late + VehiclePush::kPatience + milliseconds(1)).command.empty());
  EXPECT_EQ(push.state(), State::kRefused);
  EXPECT_EQ(push.why(), "no space; node 2 may keep the new set-up");
}

// A change that a killed recorder had under way is undone by one whose both texts are those of before: who
// refuses them may measure by what it had been given.
TEST(VehiclePushOfOneText, NamesWhoRefusesTheTextOfBefore) {
  VehiclePush push{kBefore, kBefore, {1, 2}, 5, 1, WallTime{}};
  const auto first = push.due(WallTime{});
  ASSERT_EQ(first.command.size(), 2u);
  push.take(reply(first.command[0], CommandError::kVehicleRefused, "its device cannot"));
  EXPECT_EQ(push.state(), State::kUnderWay);
  const auto second = push.due(WallTime{} + milliseconds(1));
  ASSERT_EQ(second.command.size(), 1u);
  EXPECT_EQ(second.command[0].node, 2);
  push.take(reply(second.command[0], CommandError::kNone));
  EXPECT_EQ(push.state(), State::kRefused);
  EXPECT_EQ(push.why(), "node 1: its device cannot; node 1 may keep the new set-up");
}

TEST(VehiclePushOfOneText, EndsIfItsOnlyNodeRefuses) {
  VehiclePush push{kBefore, kBefore, {1}, 5, 1, WallTime{}};
  push.take(reply(push.due(WallTime{}).command[0], CommandError::kVehicleRefused, "its device cannot"));
  EXPECT_EQ(push.state(), State::kRefused);
  EXPECT_EQ(push.why(), "node 1: its device cannot; node 1 may keep the new set-up");
}

// Its answer may be what the network lost: it is asked to take the old one, too.
TEST_F(VehiclePushTest, ANodeThatIsSilentIsGivenUpAndAskedToTakeTheOldOne) {
  const auto first = push.due(WallTime{});
  push.take(reply(first.command[0], CommandError::kNone));
  const WallTime late = WallTime{} + VehiclePush::kPatience + milliseconds(1);
  const auto undo = push.due(late);
  EXPECT_EQ(undo.command.size(), 2u);
  push.take(reply(undo.command[0], CommandError::kNone));
  EXPECT_EQ(push.state(), State::kUnderWay);
  EXPECT_TRUE(push.due(late + VehiclePush::kPatience + milliseconds(2)).command.empty());
  EXPECT_EQ(push.state(), State::kSilent);
  EXPECT_EQ(push.why(), "node 2 does not answer; node 2 may keep the new set-up");
}

// A node that obeys another recorder for the moment still has the new text: only its word ends the undoing.
TEST_F(VehiclePushTest, ARefusedUndoIsAskedAgainAndNamedIfItStaysSo) {
  const auto first = push.due(WallTime{});
  push.take(reply(first.command[0], CommandError::kNone));
  push.take(reply(first.command[1], CommandError::kVehicleRefused, "no such range"));
  const auto undo = push.due(WallTime{} + milliseconds(1));
  ASSERT_EQ(undo.command.size(), 1u);
  push.take(reply(undo.command[0], CommandError::kNotOwner, "another recorder is obeyed"));
  EXPECT_EQ(push.state(), State::kUnderWay);
  const auto again = push.due(WallTime{} + milliseconds(1) + VehiclePush::kRepeat);
  ASSERT_EQ(again.command.size(), 1u);
  EXPECT_NE(again.command[0].request, undo.command[0].request) << "the refusal of the old one may come again";
  push.take(reply(again.command[0], CommandError::kNotOwner, "another recorder is obeyed"));
  EXPECT_TRUE(push.due(WallTime{} + VehiclePush::kPatience + milliseconds(2)).command.empty());
  EXPECT_EQ(push.state(), State::kRefused);
  EXPECT_EQ(push.why(), "node 2: no such range; node 1 may keep the new set-up (another recorder is obeyed)");
}

// Right after a stop a node may still send again what the network lost.
TEST_F(VehiclePushTest, ANodeThatStillMeasuresIsAskedAgain) {
  const auto first = push.due(WallTime{});
  push.take(reply(first.command[0], CommandError::kNone));
  push.take(reply(first.command[1], CommandError::kMeasuring, "the node is measuring"));
  EXPECT_EQ(push.state(), State::kUnderWay);
  const auto second = push.due(WallTime{} + VehiclePush::kRepeat);
  ASSERT_EQ(second.command.size(), 1u);
  push.take(reply(second.command[0], CommandError::kNone));
  EXPECT_EQ(push.state(), State::kDone);
}

TEST_F(VehiclePushTest, ANodeThatMeasuresOnIsNamedWithItsReason) {
  const auto first = push.due(WallTime{});
  push.take(reply(first.command[0], CommandError::kNone));
  push.take(reply(first.command[1], CommandError::kMeasuring, "the node is measuring"));
  const auto undo = push.due(WallTime{} + VehiclePush::kPatience + milliseconds(1));
  for (const Command& command : undo.command) push.take(reply(command, CommandError::kNone));
  EXPECT_EQ(push.state(), State::kRefused);
  EXPECT_EQ(push.why(), "node 2: the node is measuring");
}

}  // namespace
}  // namespace roadbalance
