#include <gtest/gtest.h>

#include <random>

#include "common/link/blocks.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kTooFar_ns = std::int64_t{1} << 28;  // what the 28 bits of a word do not hold

Edge edge_at(std::int64_t ns, std::uint8_t line = 0, EdgeKind kind = EdgeKind::kTooth) {
  return {.time = node_time_from_ns(ns), .line = line, .kind = kind};
}

TEST(EdgeBlock, GivesBackTheEdgesThatWereAdded) {
  std::mt19937 random(5);
  EdgeBlock block;
  std::vector<Edge> added;
  std::int64_t time_ns = 9'876'543'210'123;
  for (int k = 0; k < kEdgesPerBlock; ++k) {
    added.push_back(edge_at(time_ns, random() & 1, static_cast<EdgeKind>(random() & 3)));
    ASSERT_TRUE(block.add(added.back()));
    time_ns += random() % kTooFar_ns;
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
  EXPECT_FALSE(block.add(edge_at(100 + kTooFar_ns)));
  EXPECT_TRUE(block.add(edge_at(100 + kTooFar_ns - 1)));
  EXPECT_EQ(block.unpack().back().time, node_time_from_ns(100 + kTooFar_ns - 1));
}

// edge_block_t says so: bit 0 line, bits 1..2 kind, bits 3..30 nanoseconds since the edge before.
TEST(EdgeBlock, PutsLineKindAndTimeWhereTheWireSaysAndNeverTheSign) {
  EdgeBlock block;
  ASSERT_TRUE(block.add(edge_at(1000, 1, EdgeKind::kZeroMark)));
  ASSERT_TRUE(block.add(edge_at(1005, 0, EdgeKind::kToothBackward)));
  ASSERT_TRUE(block.add(edge_at(1005 + kTooFar_ns - 1, 1, EdgeKind::kLost)));
  EXPECT_EQ(block.header.time_ns, 1000);
  EXPECT_EQ(block.words[0], 0b011);
  EXPECT_EQ(block.words[1], 5 << 3 | 0b100);
  EXPECT_EQ(block.words[2], 0x7FFFFFFF);
}

TEST(EdgeBlock, RefusesAnEdgeBeforeTheLast) {
  EdgeBlock block;
  ASSERT_TRUE(block.add(edge_at(100)));
  EXPECT_FALSE(block.add(edge_at(99)));
}

}  // namespace
}  // namespace roadbalance
