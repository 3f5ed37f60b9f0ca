#include <gtest/gtest.h>

#include <random>

#include "common/link/blocks.hpp"

namespace roadbalance {
namespace {

Edge edge_at(std::int64_t ns, std::uint8_t line = 0, EdgeKind kind = EdgeKind::kTooth) {
  return {.time = node_time_from_ns(ns), .line = line, .kind = kind};
}

TEST(EdgeBlock, GivesBackTheEdgesThatWereAdded) {
  std::mt19937 random(5);
  EdgeBlock block;
  std::vector<Edge> added;
  std::int64_t time_ns = 9'876'543'210'123;
  for (int k = 0; k < kEdgesPerBlock; ++k) {
    added.push_back(edge_at(time_ns, random() & 1, (random() & 1) ? EdgeKind::kZeroMark : EdgeKind::kTooth));
    ASSERT_TRUE(block.add(added.back()));
    time_ns += random() % (1 << 29);
  }
  const auto edges = block.unpack();
  ASSERT_EQ(edges.size(), added.size());
  for (std::size_t k = 0; k < edges.size(); ++k) {
    EXPECT_EQ(edges[k].time, added[k].time);
    EXPECT_EQ(edges[k].line, added[k].line);
    EXPECT_EQ(edges[k].kind, added[k].kind);
  }
}

TEST(EdgeBlock, TakesNoMoreThanFitsIntoADatagram) {
  EdgeBlock block;
  for (int k = 0; k < kEdgesPerBlock; ++k) ASSERT_TRUE(block.add(edge_at(k)));
  EXPECT_FALSE(block.add(edge_at(kEdgesPerBlock)));
  EXPECT_EQ(block.edges, kEdgesPerBlock);
}

TEST(EdgeBlock, RefusesAnEdgeTooFarFromTheOneBefore) {
  EdgeBlock block;
  ASSERT_TRUE(block.add(edge_at(100)));
  EXPECT_FALSE(block.add(edge_at(100 + (std::int64_t{1} << 29))));
  EXPECT_TRUE(block.add(edge_at(100 + (std::int64_t{1} << 29) - 1)));
  EXPECT_EQ(block.unpack().back().time, node_time_from_ns(100 + (std::int64_t{1} << 29) - 1));
}

TEST(EdgeBlock, RefusesAnEdgeBeforeTheLast) {
  EdgeBlock block;
  ASSERT_TRUE(block.add(edge_at(100)));
  EXPECT_FALSE(block.add(edge_at(99)));
}

}  // namespace
}  // namespace roadbalance
