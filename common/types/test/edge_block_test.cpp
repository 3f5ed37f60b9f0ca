#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/types/blocks.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kTooFar_ns = std::int64_t{1} << 30;

Edge edge_at(std::int64_t ns, std::uint8_t line = 0, EdgeKind kind = EdgeKind::kTooth) {
  return {.time = node_time_from_ns(ns), .line = line, .kind = kind};
}

void expect_same(const std::vector<Edge>& edges, const std::vector<Edge>& added) {
  ASSERT_EQ(edges.size(), added.size());
  for (std::size_t k = 0; k < edges.size(); ++k) {
    EXPECT_EQ(edges[k].time, added[k].time);
    EXPECT_EQ(edges[k].line, added[k].line);
    EXPECT_EQ(edges[k].kind, added[k].kind);
  }
}

TEST(EdgeBlock, GivesBackTheEdgesThatWereAdded) {
  std::mt19937_64 random(5);
  EdgeBlock block;
  std::vector<Edge> added;
  std::int64_t time_ns = 9'876'543'210'123;
  for (int k = 0; k < 240; ++k) {  // the longest codes fit so often
    added.push_back(edge_at(time_ns, random() & 1, static_cast<EdgeKind>(random() & 3)));
    ASSERT_TRUE(block.add(added.back()));
    time_ns += static_cast<std::int64_t>(random() % (std::uint64_t{1} << (random() % 29)));
  }
  EXPECT_TRUE(block.is_sound());
  expect_same(block.unpack(), added);
}

TEST(EdgeBlock, TakesNoMoreThanFits) {
  EdgeBlock block;
  std::vector<Edge> added;
  for (std::int64_t ns = 0; block.add(edge_at(ns)); ns += 1000 + ns % 7000) added.push_back(edge_at(ns));
  EXPECT_GT(block.size, kEdgeBytesPerBlock - static_cast<int>(kMostEdgeCodeBytes));
  EXPECT_LE(block.size, kEdgeBytesPerBlock);
  EXPECT_EQ(static_cast<std::size_t>(block.edges), added.size());
  EXPECT_TRUE(block.is_sound());
  expect_same(block.unpack(), added);
}

TEST(EdgeBlock, RefusesAnEdgeTooFarFromWhereItIsExpected) {
  EdgeBlock block;
  ASSERT_TRUE(block.add(edge_at(100)));
  EXPECT_FALSE(block.add(edge_at(100 + kTooFar_ns)));
  EXPECT_TRUE(block.add(edge_at(100 + kTooFar_ns - 1)));
  EXPECT_EQ(block.unpack().back().time, node_time_from_ns(100 + kTooFar_ns - 1));
}

TEST(EdgeBlock, RefusesAnEdgeBeforeTheLast) {
  EdgeBlock block;
  ASSERT_TRUE(block.add(edge_at(100)));
  EXPECT_FALSE(block.add(edge_at(99)));
  EXPECT_FALSE(block.add(edge_at(99, 1)));
}

// As in edge_block_t: bit 0 line, bit 1 no tooth and then bits 2..3 kind, above these what the stamp is off,
// 0 -1 1 -2 as 0 1 2 3; seven bits a byte, the lowest first.
TEST(EdgeBlock, CodesAsTheWireSays) {
  EdgeBlock block;
  ASSERT_TRUE(block.add(edge_at(1000)));                          // begins the block: off by 0
  ASSERT_TRUE(block.add(edge_at(1003, 1, EdgeKind::kZeroMark)));  // 3 after the block's begin
  ASSERT_TRUE(block.add(edge_at(1100)));                          // 100 after its tooth before: the period
  ASSERT_TRUE(block.add(edge_at(1197)));                          // expected at 1200: off by -3
  ASSERT_TRUE(block.add(edge_at(1300)));  // period 100 - 1 as -3 / 8 is rounded down: 4
  EXPECT_EQ(block.header.time_ns, 1000);
  const std::vector<std::uint8_t> codes{0,      6 << 4 | 0b0111, 0x80 | (200 << 2 & 0x7F), 200 << 2 >> 7,
                                        5 << 2, 8 << 2};
  ASSERT_EQ(static_cast<std::size_t>(block.size), codes.size());
  EXPECT_TRUE(std::ranges::equal(codes, std::span(block.codes).first(codes.size())));
}

TEST(EdgeBlock, IsNotSoundIfACodeIsNone) {
  const auto sound = [](std::vector<std::uint8_t> codes, int edges) {
    EdgeBlock block;
    std::ranges::copy(codes, block.codes.begin());
    block.size = static_cast<std::int32_t>(codes.size());
    block.edges = edges;
    return block.is_sound();
  };
  EXPECT_TRUE(sound({}, 0));
  EXPECT_TRUE(sound({0x50, 0x50}, 2));
  EXPECT_FALSE(sound({0x50, 0x50}, 1));
  EXPECT_FALSE(sound({0x50, 0x50}, 3));
  EXPECT_FALSE(sound({0x50, 0xD0}, 2)) << "does not end";
  EXPECT_FALSE(sound({0xD0, 0x00}, 1)) << "not the shortest form";
  EXPECT_FALSE(sound({0xD0, 0x80, 0x80, 0x80, 0x80, 0x01}, 1)) << "too long";
  EXPECT_FALSE(sound({0x0C}, 1)) << "before the block begins";
  EXPECT_FALSE(sound({0x52}, 1)) << "a tooth as if it were another kind";
}

}  // namespace
}  // namespace roadbalance
