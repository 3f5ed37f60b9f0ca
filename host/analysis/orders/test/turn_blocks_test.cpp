#include "host/analysis/orders/turn_blocks.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace roadbalance {
namespace {

constexpr int kRows = 8;

struct Gathered {
  std::vector<TurnBlock> block;
  TurnBlocks blocks;

  Gathered(int turns, int hop)
      : blocks({1, kRows, turns, hop}, [this](const TurnBlock& b) { block.push_back(b); }) {}

  /// Rows first .. last - 1; the value of a row is its index, its time that of 20 turns a second.
  void add(std::int64_t first, std::int64_t last, std::int64_t overloaded = -1) {
    for (std::int64_t i = first; i < last; ++i) {
      AngleRow row;
      row.index = i;
      row.restart = i == first;
      row.time_s = static_cast<double>(i) / kRows / 20.0;
      row.overload = i == overloaded ? 1 : 0;
      row.values = Eigen::VectorXd::Constant(1, static_cast<double>(i));
      blocks.add(row);
    }
  }
};

TEST(TurnBlocks, HoldWholeTurnsFromTheZeroMarkOn) {
  Gathered g(4, 4);
  g.add(3, 80);
  ASSERT_EQ(g.block.size(), 2U);
  EXPECT_EQ(g.block[0].first_turn, 1);
  EXPECT_EQ(g.block[1].first_turn, 5);
  for (const TurnBlock& b : g.block) {
    EXPECT_NEAR(b.rotation_hz, 20.0, 1e-9);
    for (Eigen::Index n = 0; n < b.values.rows(); ++n)
      ASSERT_EQ(b.values(n, 0), static_cast<double>(b.first_turn * kRows + n));
  }
}

TEST(TurnBlocks, OverlapByWholeTurns) {
  Gathered g(4, 1);
  g.add(0, 7 * kRows, 4 * kRows + 2);
  ASSERT_EQ(g.block.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(g.block[i].first_turn, static_cast<std::int64_t>(i));
    EXPECT_EQ(g.block[i].values(0, 0), static_cast<double>(i * kRows));
    EXPECT_EQ(g.block[i].overload, i >= 1 ? 1U : 0U) << "turn 4 is in block " << i;
  }
}

TEST(TurnBlocks, NeverHoldAnInterruption) {
  Gathered g(4, 2);
  g.add(0, 4 * kRows + 3);
  g.add(5 * kRows, 9 * kRows + 3);
  ASSERT_EQ(g.block.size(), 2U);
  EXPECT_EQ(g.block[1].first_turn, 5);
  EXPECT_NE(g.block[0].run, g.block[1].run);
}

TEST(TurnBlocks, RefuseNonsense) {
  for (const TurnBlocks::Settings& s :
       {TurnBlocks::Settings{0, 8, 4, 4}, {1, 1, 4, 4}, {1, 8, 4, 5}, {1, 8, 4, 0}})
    EXPECT_THROW(TurnBlocks(s, {}), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
