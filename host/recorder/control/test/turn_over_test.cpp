#include "host/recorder/control/turn_over.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

constexpr double kScale = 2e-5, kZero_counts = 1234.5;  // of the sensor, which the file knows 5 % wrong

NodeConfig node() {
  NodeConfig node{.name = "front", .id = 2, .rate_hz = 2000, .channel = {}};
  for (int k = 0; k < 2; ++k)
    node.channel.push_back({.name = "fl", .mount = "body", .scale_m_s2_per_count = 1.05 * kScale});
  return node;
}
double reads(double g) {
  return kZero_counts + g * 9.80665 / kScale;
}
WallTime at(int minutes) {
  return WallTime{} + std::chrono::minutes(minutes);
}

TEST(TurnOver, FindsScaleAndElectricalZeroInEitherOrder) {
  for (const bool up_first : {true, false}) {
    TurnOver turn_over;
    const auto first = turn_over.take(node(), 0, up_first, reads(up_first ? 1 : -1), at(0));
    EXPECT_FALSE(first.found);
    EXPECT_FALSE(first.is_refused);
    EXPECT_NE(first.text.find(up_first ? "arrow down" : "arrow up"), std::string::npos) << first.text;
    const auto second = turn_over.take(node(), 0, !up_first, reads(up_first ? -1 : 1), at(1));
    ASSERT_TRUE(second.found) << second.text;
    EXPECT_NEAR(second.found->scale_m_s2_per_count, kScale, 1e-12 * kScale);
    EXPECT_NEAR(second.found->offset_counts, kZero_counts, 1e-6);
    EXPECT_NE(second.text.find("-4.76 %"), std::string::npos) << second.text;  // 1 / 1.05 - 1
  }
}

TEST(TurnOver, ChannelsAreNotMixed) {
  TurnOver turn_over;
  turn_over.take(node(), 0, true, reads(1), at(0));
  EXPECT_FALSE(turn_over.take(node(), 1, false, reads(-1), at(1)).found);
  EXPECT_TRUE(turn_over.take(node(), 0, false, reads(-1), at(2)).found);
}

TEST(TurnOver, TheSameReadingTwiceIsNoPair) {
  TurnOver turn_over;
  turn_over.take(node(), 0, true, reads(1), at(0));
  EXPECT_FALSE(turn_over.take(node(), 0, true, reads(1), at(1)).found);
}

TEST(TurnOver, RefusesASensorThatFeelsNoGravityAndOneThatIsTheWrongWayUp) {
  TurnOver turn_over;
  turn_over.take(node(), 0, true, reads(0), at(0));
  const auto still = turn_over.take(node(), 0, false, reads(0), at(1));
  EXPECT_TRUE(still.is_refused);
  EXPECT_NE(still.text.find("measure what is steady"), std::string::npos) << still.text;
  turn_over.take(node(), 0, true, reads(-1), at(2));
  const auto inverted = turn_over.take(node(), 0, false, reads(1), at(3));
  EXPECT_TRUE(inverted.is_refused);
  EXPECT_NE(inverted.text.find("the other way"), std::string::npos) << inverted.text;
  EXPECT_FALSE(turn_over.take(node(), 0, true, reads(1), at(4)).found) << "begins again";
}

TEST(TurnOver, ForgetsWhatIsOldOrOfAnotherRange) {
  TurnOver turn_over;
  turn_over.take(node(), 0, true, reads(1), at(0));
  EXPECT_FALSE(turn_over.take(node(), 0, false, reads(-1), at(11)).found);
  turn_over.forget();
  EXPECT_FALSE(turn_over.take(node(), 0, true, reads(1), at(12)).found);
}

}  // namespace
}  // namespace roadbalance
