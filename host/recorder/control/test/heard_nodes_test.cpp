#include "host/recorder/control/heard_nodes.hpp"

#include <gtest/gtest.h>

#include "common/bus/control_messages.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using Nodes = std::vector<std::int32_t>;

const WallTime kBegin{std::chrono::hours(1)};

Heartbeat beat(std::int32_t node, NodeState state, std::int64_t base) {
  return {.node = node, .epoch = 7, .base = base, .next = 9, .state = state, .vehicle_crc32c = 5};
}

TEST(HeardNodesTest, TellsWhoIsThereAndWhoHasJustLeft) {
  const Nodes ours;
  HeardNodes heard(ours);
  heard.take(encode(beat(1, NodeState::kStarted, 3)), kBegin);
  heard.take(encode(beat(2, NodeState::kStarted, 3)), kBegin);
  EXPECT_EQ(heard.nodes(kBegin), (Nodes{1, 2}));
  EXPECT_EQ(heard.left(kBegin), Nodes{});
  // Its blocks are not acknowledged yet: not its last heartbeat.
  heard.take(encode(beat(2, NodeState::kEnded, 8)), kBegin);
  EXPECT_EQ(heard.nodes(kBegin), (Nodes{1, 2}));
  heard.take(encode(beat(2, NodeState::kEnded, 9)), kBegin);
  EXPECT_EQ(heard.nodes(kBegin), Nodes{1});
  EXPECT_EQ(heard.count(kBegin), 1);
  EXPECT_EQ(heard.left(kBegin), Nodes{2});
  EXPECT_EQ(heard.who_differs(5, "car.toml"), "");
  // It is back.
  heard.take(encode(beat(2, NodeState::kPreview, 1)), kBegin + milliseconds(900));
  EXPECT_EQ(heard.nodes(kBegin + milliseconds(900)), (Nodes{1, 2}));
  EXPECT_EQ(heard.left(kBegin + milliseconds(900)), Nodes{});
}

TEST(HeardNodesTest, WhoeverHasLeftForGoodIsForgotten) {
  const Nodes ours;
  HeardNodes heard(ours);
  heard.take(encode(beat(2, NodeState::kEnded, 9)), kBegin);
  EXPECT_EQ(heard.left(kBegin + milliseconds(3000)), Nodes{2});
  EXPECT_EQ(heard.left(kBegin + milliseconds(3001)), Nodes{});
}

// A node that measures by another file is named while it is there.
TEST(HeardNodesTest, WhoHasLeftDiffersFromNobody) {
  const Nodes ours;
  HeardNodes heard(ours);
  heard.take(encode(beat(2, NodeState::kStarted, 3)), kBegin);
  EXPECT_NE(heard.who_differs(6, "car.toml").find("node 2 measures by another vehicle file"),
            std::string::npos);
  heard.take(encode(beat(2, NodeState::kEnded, 9)), kBegin);
  EXPECT_EQ(heard.who_differs(6, "car.toml"), "");
}

}  // namespace
}  // namespace roadbalance
