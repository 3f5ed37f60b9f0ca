#include "tools/rb/readout.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Balance known(double grams, double degrees) {
  Balance balance;
  balance.wheel = 0;
  balance.state = Unknown::kNone;
  balance.unbalance_g = grams;
  balance.angle_rad = degrees * kDegree;
  balance.sigma_g = 2.0;
  balance.sigma_rad = 2.6 * kDegree;
  balance.covariance_g2 = Eigen::Matrix2d::Identity() * 4.0;
  return balance;
}

TEST(BalanceLine, SaysHeavySpotMassAndHowSure) {
  EXPECT_EQ(balance_line(known(35.0, 217.0)), "front left:  heavy spot 217°, 35.0 g, ± 2.0 g ± 3°");
  EXPECT_EQ(balance_line(known(35.0, 359.7)), "front left:  heavy spot   0°, 35.0 g, ± 2.0 g ± 3°");
}

TEST(BalanceLine, SaysWhyItIsNotKnown) {
  Balance balance;
  balance.wheel = 3;
  balance.state = Unknown::kTooSlow;
  EXPECT_EQ(balance_line(balance), "rear right:  not known: the car never went fast enough");
  EXPECT_EQ(advice_line(balance), "");
}

TEST(IdentificationLine, SaysHowFarItIsFromAnEstimate) {
  Identification identification;
  EXPECT_EQ(identification_line(identification),
            "suspension: not known: not enough driving at a steady speed yet");
  identification.sections = 4;
  identification.seconds_used = 40.0;
  EXPECT_EQ(identification_line(identification),
            "suspension: not known: 40 s of steady driving so far, 60 needed");
}

TEST(NodeLine, SaysWhatANodeCounts) {
  Heartbeat beat;
  beat.node = 2;
  beat.scans_sampled = 12'000;
  beat.scans_missing = 3;
  beat.blocks_repaired = 7;
  beat.ring_used = 50;
  beat.ring_capacity = 1'000;
  EXPECT_EQ(node_line(beat), "node 2: 12000 samples taken, 3 missing, 7 blocks repaired, ring 5 % full");
}

// 30 g opposite to 217 deg: two weights of 15 g side by side at 37 deg.
TEST(AdviceLine, SaysWhereToClipStockWeights) {
  EXPECT_EQ(advice_line(known(30.0, 217.0)), "clip 15 g at 37° and at 37°");
}

// sqrt(5.99) * 2 g = 4.9 g is the radius of the 95 % circle.
TEST(AdviceLine, LeavesAWheelAloneThatMayHaveNoUnbalance) {
  EXPECT_EQ(advice_line(known(4.8, 90.0)), "leave it: the unbalance is within its own uncertainty");
  EXPECT_EQ(advice_line(known(5.0, 90.0)).substr(0, 4), "clip");
}

TEST(LevelLines, MarkDeadAndOverloadedChannels) {
  Level level;
  level.node = 2;
  level.speed_m_s = 100.0 / 3.6;
  level.dead = 1U << 3;
  level.overload = 1U << 5;
  const auto lines = level_lines(level);
  ASSERT_EQ(lines.size(), 1U + kAccelerations);
  EXPECT_EQ(lines[0], "node 2: 100.0 km/h");
  EXPECT_NE(lines[4].find("DEAD"), std::string::npos);
  EXPECT_NE(lines[6].find("OVERLOAD"), std::string::npos);
  EXPECT_EQ(lines[5].find("DEAD"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
