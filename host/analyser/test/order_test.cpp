#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <stdexcept>
#include <vector>

#include "host/analyser/durable_gate.hpp"
#include "host/analyser/in_sequence.hpp"

namespace roadbalance {
namespace {

SealedBlock block(std::int32_t node, std::int64_t epoch, std::int64_t sequence) {
  SealedBlock sealed;
  sealed.header.node = node;
  sealed.header.epoch = epoch;
  sealed.header.sequence = sequence;
  return sealed;
}

TEST(InSequence, HandsOverEveryBlockOnceInSequenceWhateverTheOrder) {
  std::vector<SealedBlock> blocks;
  for (std::int64_t s = 1; s <= 50; ++s)
    for (const std::int64_t epoch : {7, 8}) {
      blocks.push_back(block(1, epoch, s));
      blocks.push_back(block(1, epoch, s));
    }
  std::mt19937 random(3);
  std::shuffle(blocks.begin(), blocks.end(), random);

  InSequence in_sequence;
  std::map<std::int64_t, std::int64_t> last;
  int count = 0;
  for (const auto& b : blocks)
    in_sequence.add(b, [&](const SealedBlock& next) {
      EXPECT_EQ(next.header.sequence, ++last[next.header.epoch]);
      ++count;
    });
  EXPECT_EQ(count, 100);
}

TEST(InSequence, AGapOfLostBlocksStandsForThemAll) {
  GapBlock gap;
  gap.header = {1, 7, 5, 40, 60, 0};  // blocks 3, 4 and 5 are lost
  gap.cause = GapCause::kLostAtNode;
  SealedBlock lost;
  seal(gap, lost);
  for (const bool gap_first : {false, true}) {
    InSequence in_sequence;
    std::vector<std::int64_t> seen;
    const auto add = [&](const SealedBlock& b) {
      in_sequence.add(b, [&](const SealedBlock& next) { seen.push_back(next.header.sequence); });
    };
    add(block(1, 7, 1));
    if (!gap_first) add(block(1, 7, 6));
    add(block(1, 7, 2));
    add(lost);
    if (gap_first) add(block(1, 7, 6));
    EXPECT_EQ(seen, (std::vector<std::int64_t>{1, 2, 5, 6}));
  }
}

TEST(InSequence, NamesTheBlockThatStaysMissing) {
  InSequence in_sequence;
  const auto fill = [&] {
    for (std::int64_t s = 2; s < 100'000; ++s)
      in_sequence.add(block(3, 1, s), [](const SealedBlock&) { FAIL(); });
  };
  EXPECT_THROW(fill(), std::runtime_error);
}

TEST(DurableGate, LetsThroughWhatIsAcknowledgedAsDurableAndNoMore) {
  const WallTime begin{};
  DurableGate gate(begin);
  Ack ack;
  ack.node = 1;
  ack.epoch = 5;
  ack.durable = 10;
  ack.received = 20;
  gate.acknowledge(ack, begin);
  EXPECT_TRUE(gate.passes(block(1, 5, 10).header, begin));
  EXPECT_FALSE(gate.passes(block(1, 5, 11).header, begin));
  EXPECT_FALSE(gate.passes(block(1, 6, 1).header, begin));
  EXPECT_FALSE(gate.passes(block(2, 5, 1).header, begin));
  EXPECT_TRUE(gate.passes(block(0, 0, 0).header, begin));  // what the recorder begins a segment with
  ack.durable = 4;                                         // a stale datagram
  gate.acknowledge(ack, begin);
  EXPECT_TRUE(gate.passes(block(1, 5, 10).header, begin));
}

TEST(DurableGate, OpensWhenTheRecorderHasGone) {
  const WallTime begin{};
  DurableGate gate(begin);
  gate.acknowledge(Ack{}, begin + std::chrono::seconds(10));
  EXPECT_FALSE(gate.passes(block(1, 5, 11).header, begin + std::chrono::seconds(12)));
  EXPECT_TRUE(gate.passes(block(1, 5, 11).header, begin + std::chrono::seconds(14)));
}

}  // namespace
}  // namespace roadbalance
