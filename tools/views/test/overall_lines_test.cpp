#include "tools/views/overall_lines.hpp"

#include <gtest/gtest.h>

#include <string>

namespace roadbalance {
namespace {

TEST(OverallLines, SayNoMoreDigitsThanAreKnown) {
  OverallPlan plan;
  plan.vibration = {.now = 0.051234, .by_wheel = 0.0123456, .overall = 0.0098765, .least = 0.0};
  EXPECT_EQ(overall_lines(plan).back(), "  all               0.051     0.012   0.0099        0");
}

TEST(OverallLines, NameTheWheelsThatTellNoForce) {
  OverallPlan plan;
  plan.speed = {{.speed_m_s = 25.0, .seconds = 60.0, .vibration = {}},
                {.speed_m_s = 30.0, .seconds = 60.0, .vibration = {}}};
  const std::size_t whole = overall_lines(plan).size();
  plan.speed[0].without_force.set(1);
  plan.speed[0].without_force.set(2);
  plan.speed[1].without_force.set(2);
  const auto lines = overall_lines(plan);
  ASSERT_EQ(lines.size(), whole + 2);
  EXPECT_NE(lines[whole].find("front_right at 90 km/h"), std::string::npos) << lines[whole];
  EXPECT_NE(lines[whole + 1].find("rear_left, at no speed"), std::string::npos) << lines[whole + 1];
  const auto json = overall_json(plan);
  EXPECT_EQ(json["speeds"][0]["without_force"].size(), 2U);
  EXPECT_EQ(json["speeds"][1]["without_force"][0], "rear_left");
}

}  // namespace
}  // namespace roadbalance
