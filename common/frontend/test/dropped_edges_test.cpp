#include "common/frontend/dropped_edges.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace roadbalance {
namespace {

Edge edge_at(std::int64_t ns, std::uint8_t line, EdgeKind kind = EdgeKind::kTooth) {
  return {.time = node_time_from_ns(ns), .line = line, .kind = kind};
}

/// Takes so many edges.
struct Queue {
  explicit Queue(std::size_t most_edges) : most(most_edges) {}
  bool pass(DroppedEdges& dropped, const Edge& edge) {
    return dropped.pass(edge, [this](const Edge& kept) {
      if (kept_edges.size() == most) return false;
      kept_edges.push_back(kept);
      return true;
    });
  }
  std::size_t most;
  std::vector<Edge> kept_edges;
};

TEST(DroppedEdges, PutsAMarkBeforeTheNextEdgeOfTheLineAndOfNoOther) {
  DroppedEdges dropped;
  Queue queue(9);
  EXPECT_TRUE(queue.pass(dropped, edge_at(10, 0)));
  EXPECT_TRUE(dropped.drop(0));
  EXPECT_FALSE(dropped.drop(0)) << "the same hole";
  EXPECT_TRUE(queue.pass(dropped, edge_at(20, 1)));
  EXPECT_TRUE(queue.pass(dropped, edge_at(30, 0)));
  EXPECT_TRUE(queue.pass(dropped, edge_at(40, 0)));
  ASSERT_EQ(queue.kept_edges.size(), 5U);
  EXPECT_EQ(queue.kept_edges[1].line, 1);
  EXPECT_EQ(queue.kept_edges[2].kind, EdgeKind::kLost);
  EXPECT_EQ(queue.kept_edges[2].line, 0);
  EXPECT_EQ(to_ns(queue.kept_edges[2].time), 29);
  EXPECT_EQ(queue.kept_edges[3].kind, EdgeKind::kTooth);
  EXPECT_EQ(queue.kept_edges[4].kind, EdgeKind::kTooth);
  EXPECT_TRUE(dropped.drop(0)) << "another hole";
}

TEST(DroppedEdges, NeverPassesAnEdgeWithoutItsMark) {
  DroppedEdges dropped;
  Queue queue(1);
  ASSERT_TRUE(dropped.drop(1));
  EXPECT_FALSE(queue.pass(dropped, edge_at(10, 1))) << "room for the mark only";
  EXPECT_FALSE(dropped.drop(1));
  EXPECT_EQ(queue.kept_edges.size(), 1U);
  queue.most = 9;
  EXPECT_TRUE(queue.pass(dropped, edge_at(20, 1)));
  ASSERT_EQ(queue.kept_edges.size(), 3U);
  EXPECT_EQ(queue.kept_edges[1].kind, EdgeKind::kLost);
  EXPECT_EQ(queue.kept_edges[2].kind, EdgeKind::kTooth);
}

TEST(DroppedEdges, TakesTheDevicesOwnMarkForOne) {
  DroppedEdges dropped;
  Queue queue(9);
  ASSERT_TRUE(dropped.drop(0));
  EXPECT_TRUE(queue.pass(dropped, edge_at(10, 0, EdgeKind::kLost)));
  EXPECT_TRUE(queue.pass(dropped, edge_at(20, 0)));
  ASSERT_EQ(queue.kept_edges.size(), 2U);
  EXPECT_EQ(to_ns(queue.kept_edges[0].time), 10);
}

}  // namespace
}  // namespace roadbalance
