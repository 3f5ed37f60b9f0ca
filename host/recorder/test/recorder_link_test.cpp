#include "host/recorder/recorder_link.hpp"

#include <gtest/gtest.h>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr std::int32_t kNode = 2;
constexpr std::int64_t kEpoch = 8;
constexpr std::int64_t kOurs = 50, kOther = 49;

class RecorderLinkTest : public ::testing::Test {
 protected:
  void hear(std::int64_t owner, std::int64_t base, std::int64_t next) {
    link.take(heartbeat_channel(kNode),
              encode(Heartbeat{.node = kNode,
                               .epoch = kEpoch,
                               .base = base,
                               .next = next,
                               .state = NodeState::kStarted,
                               .owner = owner}),
              now);
  }
  void send(std::int64_t first, std::int64_t last) {
    for (std::int64_t sequence = first; sequence <= last; ++sequence) {
      ScanBlock block;
      block.header = {.node = kNode,
                      .epoch = kEpoch,
                      .sequence = sequence,
                      .first_scan = 20 * (sequence - 1),
                      .scans = 20,
                      .time_ns = sequence};
      block.period_ps = 500'000'000;
      SealedBlock sealed;
      seal(block, sealed);
      link.take(block_channel(kNode, BlockKind::kScan), sealed.bytes(), now);
    }
  }
  void send_end(std::int64_t sequence) {
    SealedBlock end;
    seal(EndBlock{.header = {.node = kNode,
                             .epoch = kEpoch,
                             .sequence = sequence,
                             .first_scan = 20 * (sequence - 1)}},
         end);
    link.take(block_channel(kNode, BlockKind::kEnd), end.bytes(), now);
  }
  // Acknowledgements sent in a second, with a heartbeat each 100 ms.
  int run(std::int64_t owner, std::int64_t base, std::int64_t next) {
    int acks = 0;
    for (int k = 0; k < 10; ++k, now += milliseconds(100)) {
      hear(owner, base, next);
      link.turn(now, [&acks](const std::string& channel, auto) {
        acks += channel == ack_channel(kNode) ? 1 : 0;
        return true;
      });
    }
    return acks;
  }

  // Nodes, in the end.
  int released() {
    int count = 0;
    link.farewell([&count](const std::string&, std::span<const std::uint8_t> bytes) {
      const auto command = decode_command(bytes);
      count += command && command->verb == Verb::kRelease ? 1 : 0;
      return true;
    });
    return count;
  }

  RecorderLink link{{}, kOurs, {}};
  WallTime now{std::chrono::hours(1)};
};

TEST_F(RecorderLinkTest, RecordsNothingOfANodeThatObeysAnotherAndSaysSoOnce) {
  std::vector<std::string> said;
  for (int k = 1; k <= 6; ++k) {
    EXPECT_EQ(run(kOther, 5 * k, 5 * k + 20), 0);
    send(5 * k, 5 * k + 4);
    for (auto& sentence : link.warnings()) said.push_back(sentence);
  }
  EXPECT_TRUE(link.deliveries().empty());
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("node 2 obeys another recorder (incarnation 49)"), std::string::npos) << said[0];
  EXPECT_EQ(link.report().foreign, std::vector<std::int32_t>{kNode});
  EXPECT_TRUE(link.report().node.empty());
}

TEST_F(RecorderLinkTest, KeepsTheHighestOfEachCounterOfANodesHeartbeats) {
  Heartbeat heartbeat{.node = kNode, .epoch = kEpoch, .base = 1, .next = 2, .owner = kOurs};
  const auto hear_counts = [&](std::int64_t plus) {
    heartbeat.spool_failures = 10 + plus;
    heartbeat.scans_refused = 20 + plus;
    heartbeat.blocks_repaired = 30 + plus;
    heartbeat.blocks_unsent = 40 + plus;
    heartbeat.acks_refused = 50 + plus;
    heartbeat.encoder_faults = {60 + plus, 70 + plus};
    heartbeat.unreferenced_blocks = 80 + plus;
    heartbeat.device_counts.fill(90 + plus);
    link.take(heartbeat_channel(kNode), encode(heartbeat), now);
  };
  hear_counts(1);
  hear_counts(3);
  hear_counts(2);  // overtaken on the way
  NodeLosses highest{.repaired = 33,
                     .spool_failures = 13,
                     .scans_refused = 23,
                     .blocks_unsent = 43,
                     .acks_refused = 53,
                     .encoder_faults = {63, 73},
                     .unreferenced_blocks = 83};
  highest.device_counts.fill(93);
  const auto counters = link.counters();
  ASSERT_EQ(counters.node.size(), 1u);
  EXPECT_EQ(counters.node.begin()->second, highest);
}

TEST_F(RecorderLinkTest, CountsWhatIsDamagedAndNotWhatIsForAnother) {
  RecorderLinkOptions options;
  options.nodes = {1};
  RecorderLink of_node_1{options, kOurs, {}};
  SealedBlock sealed;
  ScanBlock block;
  block.header = {.node = kNode, .epoch = kEpoch, .sequence = 1, .first_scan = 0, .scans = 20, .time_ns = 1};
  block.period_ps = 500'000'000;
  seal(block, sealed);
  const std::string channel = block_channel(kNode, BlockKind::kScan);
  of_node_1.take(channel, sealed.bytes(), now);
  EXPECT_EQ(of_node_1.report().blocks_refused, 0);
  of_node_1.take(channel, sealed.bytes().first(sealed.bytes().size() / 2), now);
  EXPECT_EQ(of_node_1.report().blocks_refused, 1);
}

// The rest of one recording is fetched while the next one is under way: neither touches what is the other's.
TEST_F(RecorderLinkTest, KeepsToTheEpochsOfItsScope) {
  RecorderLinkOptions rest, next;
  rest.start = false;
  rest.scope.only = {{kNode, kEpoch}};
  next.scope.not_these = {{kNode, kEpoch}};
  RecorderLink of_rest{rest, kOurs, {}}, of_next{next, kOurs + 1, {}};
  const auto claims = [this](RecorderLink& of) {
    std::vector<std::int64_t> epochs;
    for (const std::int64_t epoch : {kEpoch, kEpoch + 1})
      of.take(heartbeat_channel(kNode), encode(Heartbeat{.node = kNode, .epoch = epoch}), now);
    of.turn(now, [&epochs](const std::string& channel, auto bytes) {
      if (channel == command_channel(kNode)) epochs.push_back(decode_command(bytes)->epoch);
      return true;
    });
    return epochs;
  };
  EXPECT_EQ(claims(of_rest), std::vector<std::int64_t>{kEpoch});
  EXPECT_EQ(claims(of_next), std::vector<std::int64_t>{kEpoch + 1});
}

// It was cut off before anybody had heard of it, and is back while the next one is recorded.
TEST_F(RecorderLinkTest, WhatWasStartedForARecordingBeforeIsNotTakenIntoThisOne) {
  RecorderLinkOptions options;
  options.scope.not_started_by = {{kOther - 1, kOther + 1}};
  RecorderLink next{options, kOurs, {}};
  const auto claims = [&](Heartbeat beat) {
    int count = 0;
    beat.node = kNode;
    next.take(heartbeat_channel(kNode), encode(beat), now += milliseconds(200));
    next.turn(now, [&](const std::string& channel, auto bytes) {
      count += channel == command_channel(kNode) && decode_command(bytes)->epoch == beat.epoch;
      return true;
    });
    return count;
  };
  const Heartbeat started{.epoch = kEpoch, .base = 1, .next = 9, .state = NodeState::kStarted};
  Heartbeat beat = started;
  beat.owner = kOther;
  EXPECT_EQ(claims(beat), 0);
  beat.owner = kOurs + 5;
  EXPECT_EQ(claims(beat), 0) << "its rest is being fetched";
  beat.epoch = kEpoch + 1;
  beat.owner = 0;
  EXPECT_EQ(claims(beat), 1) << "started, and nobody's";
  EXPECT_EQ(claims({.epoch = kEpoch + 2, .state = NodeState::kPreview, .owner = kOther}), 1)
      << "it never got its start, and holds nothing";
  EXPECT_EQ(claims({.epoch = kEpoch + 3, .base = 3, .next = 9, .state = NodeState::kEnded, .owner = kOther}),
            0);
}

// The other one has died: what the node still holds is all that is not in its record.
TEST_F(RecorderLinkTest, RecordsAllThatTheNodeHoldsOnceItObeysUs) {
  run(kOther, 40, 50);
  send(40, 49);
  EXPECT_GT(run(kOurs, 40, 50), 0);
  send(40, 49);
  std::vector<std::int64_t> blocks;
  for (const Delivery& delivery : link.deliveries())
    if (const auto* block = std::get_if<SealedBlock>(&delivery)) blocks.push_back(block->header.sequence);
  EXPECT_EQ(blocks, (std::vector<std::int64_t>{40, 41, 42, 43, 44, 45, 46, 47, 48, 49}));
  EXPECT_TRUE(link.report().foreign.empty());
  run(kOther, 50, 50);
  send(50, 52);
  EXPECT_EQ(link.deliveries().size(), 3u) << "what was begun here is gone on with";
}

TEST_F(RecorderLinkTest, NotesWhatDevicesOfItsOwnNodesSufferAndTheRestAtTheEnd) {
  const auto hear_gone = [this](std::int64_t owner, std::int64_t times) {
    Heartbeat beat{.node = kNode, .epoch = kEpoch, .base = 1, .next = 2, .owner = owner};
    beat.device_counts[static_cast<std::size_t>(DeviceCounter::kGone)] = times;
    link.take(heartbeat_channel(kNode), encode(beat), now);
  };
  hear_gone(kOther, 1);
  EXPECT_TRUE(link.device_notes().empty());
  hear_gone(kOurs, 2);
  const auto notes = link.device_notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].node, kNode);
  EXPECT_EQ(notes[0].counter, DeviceCounter::kGone);
  EXPECT_EQ(notes[0].text, "was unplugged or went down (2 times by now)");
  hear_gone(kOurs, 3);
  EXPECT_TRUE(link.device_notes().empty());
  now += std::chrono::seconds(2);
  link.set_credit_open(false);
  hear_gone(kOurs, 4);
  EXPECT_TRUE(link.device_notes().empty()) << "a disk that fails would not take it";
  link.set_credit_open(true);
  hear_gone(kOurs, 4);
  EXPECT_EQ(link.device_notes().size(), 1u);
  hear_gone(kOurs, 5);
  link.finish(now);
  ASSERT_EQ(link.device_notes().size(), 1u);
}

TEST_F(RecorderLinkTest, TheLeaseOfADeadRecorderIsNoNews) {
  run(kOther, 1, 2);
  run(kOurs, 1, 2);
  EXPECT_TRUE(link.warnings().empty());
}

// It was held between its last block and its next heartbeat: the next recording must not take these for its
// own.
TEST_F(RecorderLinkTest, ANodeHoldsItsLastBlocksUntilAHeartbeatFromBehindThem) {
  run(kOurs, 1, 1);
  send(1, 1);
  send_end(2);
  link.durable({kNode, kEpoch, 2}, now);
  (void)link.deliveries();
  ASSERT_EQ(link.report().node.size(), 1u);
  EXPECT_TRUE(link.report().node[0].ended);
  EXPECT_TRUE(link.report().node[0].holds_blocks)
      << "the heartbeat that said nothing is held was before them";
  hear(kOurs, 2, 3);
  EXPECT_TRUE(link.report().node[0].holds_blocks);
  hear(kOurs, 3, 3);
  EXPECT_FALSE(link.report().node[0].holds_blocks);
}

// The disk failed over a stop: its owner's number shows later whose samples the node holds.
TEST_F(RecorderLinkTest, ANodeIsReleasedOnlyWhenNothingItHoldsHangsOnIt) {
  run(kOurs, 1, 3);
  send(1, 1);
  send_end(2);
  (void)link.deliveries();
  EXPECT_EQ(released(), 0) << "its end is not on the disk";
  link.durable({kNode, kEpoch, 2}, now);
  EXPECT_EQ(released(), 0) << "it has not heard so";
  hear(kOurs, 3, 3);
  EXPECT_EQ(released(), 1);
}

// An answer does not show what it holds for the recorder before.
TEST_F(RecorderLinkTest, ANodeThatHasOnlyAnsweredIsNotReleased) {
  hear(kOther, 1, 9);
  link.turn(now, [this](const std::string&, std::span<const std::uint8_t> bytes) {
    link.take(reply_channel(kNode), encode(Reply{kNode, kEpoch, decode_command(bytes)->request}), now);
    return true;
  });
  EXPECT_EQ(released(), 0);
}

// Blocks of a node that another recorder ends are no reason to wait.
TEST_F(RecorderLinkTest, NamesTheNodeForWhichThereIsNoRoom) {
  RecorderStatus status;
  for (std::int32_t node = 1; node <= static_cast<std::int32_t>(kMostNodes) + 1; ++node) {
    link.fill(status);
    EXPECT_EQ(status.left_out, 0) << node;
    link.take(heartbeat_channel(node), encode(Heartbeat{.node = node, .epoch = node, .owner = kOurs}), now);
  }
  link.fill(status);
  EXPECT_EQ(status.left_out, static_cast<std::int32_t>(kMostNodes) + 1);
  int claimed = 0;
  link.turn(now, [&](const std::string& channel, auto) {
    claimed += channel == command_channel(status.left_out) ? 1 : 0;
    return true;
  });
  EXPECT_EQ(claimed, 0) << "it waits for a recorder that has room";
}

TEST_F(RecorderLinkTest, NotesTheStopBehindWhatWasMissedBefore) {
  RecorderLinkOptions options;
  options.expected = {{.number = 7, .name = "rear", .is_missing = true}};
  RecorderLink with_expected{options, kOurs, {}};
  const Publish nobody = [](const std::string&, auto) { return true; };
  with_expected.turn(now, nobody);
  now += milliseconds(1500);
  with_expected.stop(now, "rb of anna at laptop");
  const auto notes = with_expected.notes();
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_EQ(notes[0].kind, NoteKind::kNodeMissing);
  EXPECT_EQ(notes[0].a, 7);
  EXPECT_EQ(notes[1].kind, NoteKind::kStopping);
  EXPECT_EQ(notes[1].text, "rb of anna at laptop");
}

TEST_F(RecorderLinkTest, NotesInTheEndWhoNeverCameToAShortRecording) {
  RecorderLinkOptions options;
  options.expected = {{.number = 7, .name = "rear"}};
  RecorderLink with_expected{options, kOurs, {}};
  const Publish nobody = [](const std::string&, auto) { return true; };
  with_expected.turn(now, nobody);
  now += milliseconds(1500);
  with_expected.stop(now, kStoppedBySignal);
  with_expected.finish(now);
  const auto notes = with_expected.notes();
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_EQ(notes[0].kind, NoteKind::kStopping);
  EXPECT_EQ(notes[1].kind, NoteKind::kNodeMissing);
  EXPECT_EQ(notes[1].a, 7);
  EXPECT_EQ(static_cast<AbsenceCause>(notes[1].b), AbsenceCause::kNeverCame);
  ASSERT_EQ(with_expected.absences(now, 0).size(), 1u);
}

TEST_F(RecorderLinkTest, EndsThoughANodeThatObeysAnotherGoesOn) {
  run(kOurs, 1, 2);
  send(1, 1);
  run(kOther, 2, 3);
  link.stop(now);
  std::int64_t sequence = 1;
  const WallTime stopped = now;
  while (!link.over(now) && now - stopped < std::chrono::seconds(60)) {
    run(kOther, sequence + 1, sequence + 2);
    ++sequence;
    send(sequence, sequence);
    (void)link.deliveries();
  }
  EXPECT_LT(now - stopped, std::chrono::seconds(30));
}

}  // namespace
}  // namespace roadbalance
