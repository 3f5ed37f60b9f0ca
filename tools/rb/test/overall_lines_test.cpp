#include "tools/rb/overall_lines.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(OverallLines, SayNoMoreDigitsThanAreKnown) {
  OverallPlan plan;
  plan.vibration = {.now = 0.051234, .by_wheel = 0.0123456, .overall = 0.0098765, .least = 0.0};
  EXPECT_EQ(overall_lines(plan).back(), "  all               0.051     0.012   0.0099        0");
}

}  // namespace
}  // namespace roadbalance
