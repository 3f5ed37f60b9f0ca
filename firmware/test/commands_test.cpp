#include "firmware/commands.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

constexpr std::int32_t kNode = 3;
constexpr std::int64_t kEpoch = 9, kOwner = 4;

struct Fixture : testing::Test {
  Ring ring{64 * sizeof(SealedBlock)};
  Backlog backlog{ring};
  Sender sender{backlog, kNode, kEpoch};
  AcquireLink link;
  VehicleChange vehicle{"old", true};
  Commands commands{kNode, kEpoch, backlog, sender, link, vehicle};
  WallTime now{};

  std::optional<Reply> say(Verb verb, std::int64_t request, std::int64_t incarnation = kOwner) {
    commands.take({.node = kNode, .request = request, .incarnation = incarnation, .verb = verb}, now);
    return commands.next_reply();
  }
};
using NodeCommands = Fixture;

TEST_F(NodeCommands, StartOnlyForTheOwner) {
  EXPECT_EQ(say(Verb::kStart, 1)->result, CommandError::kNotOwner);
  EXPECT_EQ(link.start_at.load(), AcquireLink::kNotAsked);
  EXPECT_EQ(say(Verb::kClaim, 2)->result, CommandError::kNone);
  EXPECT_EQ(say(Verb::kClaim, 3, kOwner + 1)->result, CommandError::kNotOwner);  // the lease lives
  const auto reply = say(Verb::kStart, 4);
  EXPECT_EQ(reply->result, CommandError::kNone);
  EXPECT_EQ(reply->sequence, 1);
  EXPECT_EQ(reply->epoch, kEpoch);
  EXPECT_EQ(link.start_at.load(), now);
}

// The commands took different times on their way to the node, and came once more under the same number.
TEST_F(NodeCommands, AStartAndAStopNameTheirInstantAndTheQuickestKnowsItBest) {
  using namespace std::chrono_literals;
  say(Verb::kClaim, 1);
  const auto announce = [&](Verb verb, std::int64_t request, std::int64_t delay_us) {
    commands.take(
        {.node = kNode, .request = request, .incarnation = kOwner, .verb = verb, .delay_us = delay_us}, now);
  };
  const WallTime instant = now + 100ms;
  now += 30ms;
  announce(Verb::kStart, 2, 100'000);
  EXPECT_EQ(link.start_at.load(), instant + 30ms);
  now += 10ms;
  announce(Verb::kStart, 2, 65'000);
  EXPECT_EQ(link.start_at.load(), instant + 5ms);
  now += 20ms;
  announce(Verb::kStart, 3, 60'000);
  EXPECT_EQ(link.start_at.load(), instant + 5ms);
  now += 500ms;
  announce(Verb::kStop, 4, -20'000);
  EXPECT_EQ(link.stop_at.load(), now - 20ms);
  announce(Verb::kStop, 4, -25'000);
  EXPECT_EQ(link.stop_at.load(), now - 25ms);
}

// A start that the network delivers late must not start the epoch after the one that it was for.
TEST_F(NodeCommands, WhatIsForAnotherEpochIsNotObeyed) {
  say(Verb::kClaim, 1);
  commands.take(
      {.node = kNode, .request = 2, .incarnation = kOwner, .verb = Verb::kStart, .epoch = kEpoch + 1}, now);
  EXPECT_FALSE(commands.next_reply());
  EXPECT_EQ(link.start_at.load(), AcquireLink::kNotAsked);
  commands.take({.node = kNode, .request = 3, .incarnation = kOwner, .verb = Verb::kStart, .epoch = kEpoch},
                now);
  EXPECT_TRUE(commands.next_reply());
  EXPECT_EQ(link.start_at.load(), now);
}

TEST_F(NodeCommands, ARefusedClaimIsToldTheHighestIncarnationObeyed) {
  say(Verb::kClaim, 1, 90);
  EXPECT_EQ(say(Verb::kClaim, 2, 50)->sequence, 90);
  say(Verb::kRelease, 3, 90);
  const auto reply = say(Verb::kClaim, 4, 50);
  EXPECT_EQ(reply->result, CommandError::kNotOwner);
  EXPECT_EQ(reply->sequence, 90) << "nobody owns it, and yet it obeys no older one";
  EXPECT_EQ(say(Verb::kClaim, 5, 91)->result, CommandError::kNone);
}

// A recorder sends once that it gives a node back, and the network may lose that.
TEST_F(NodeCommands, AnIdleNodeIsSetUpWhenItsOwnerIsSilentAndNotBefore) {
  const auto configure = [&](std::int64_t request) {
    commands.take({.node = kNode,
                   .request = request,
                   .incarnation = kOwner + 1,
                   .verb = Verb::kConfigure,
                   .vehicle_crc32c = vehicle.in_force()},
                  now);
    return commands.next_reply()->result;
  };
  say(Verb::kClaim, 1);
  now += std::chrono::milliseconds(700);
  EXPECT_EQ(configure(2), CommandError::kNotOwner) << "the lease lives";
  now += std::chrono::milliseconds(1);
  EXPECT_EQ(configure(2), CommandError::kNone);
}

TEST_F(NodeCommands, ARepeatedRequestActsOnceAndGetsTheSameReply) {
  say(Verb::kClaim, 1);
  EXPECT_EQ(say(Verb::kRelease, 2)->result, CommandError::kNone);
  say(Verb::kClaim, 3);
  EXPECT_EQ(say(Verb::kRelease, 2)->result, CommandError::kNone);
  EXPECT_EQ(sender.owner(), kOwner);  // the release of request 2 was over already
}

TEST_F(NodeCommands, StopIsAnsweredWithTheEndsSequenceOnceItIsSealed) {
  say(Verb::kClaim, 1);
  say(Verb::kStart, 2);
  EXPECT_FALSE(say(Verb::kStop, 3).has_value());
  EXPECT_FALSE(say(Verb::kStop, 3).has_value());
  EXPECT_EQ(link.stop_at.load(), now);
  EXPECT_TRUE(commands.waiting());
  SealedBlock* block = ring.claim();
  block->header.sequence = 1;
  ring.commit();
  link.state = NodeState::kEnded;
  const auto reply = commands.next_reply();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->request, 3);
  EXPECT_EQ(reply->sequence, 1);
  const auto again = say(Verb::kStop, 3);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->sequence, 1);
  EXPECT_FALSE(commands.waiting());
}

TEST_F(NodeCommands, AnEndedNodeDoesNotStartAgainAndAnUnknownVerbIsRefused) {
  say(Verb::kClaim, 1);
  link.state = NodeState::kEnded;
  EXPECT_EQ(say(Verb::kStart, 2)->result, CommandError::kEnded);
  EXPECT_EQ(say(static_cast<Verb>(77), 3)->result, CommandError::kUnknownVerb);
  EXPECT_EQ(link.start_at.load(), AcquireLink::kNotAsked);
}

TEST_F(NodeCommands, OfAnotherNodeAreNotHeard) {
  commands.take({kNode + 1, 1, kOwner, Verb::kClaim}, now);
  EXPECT_FALSE(commands.next_reply());
  EXPECT_EQ(sender.owner(), 0);
}

}  // namespace
}  // namespace roadbalance
