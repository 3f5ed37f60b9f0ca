#include "host/analysis/identify/diagnostics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "host/analysis/identify/first_order.hpp"

namespace roadbalance {
namespace {

struct Found {
  std::array<Balance, kWheels> balance{};
  Found() {
    for (Balance& wheel : balance) wheel.state = Unknown::kNone;
  }
  bool contains(const std::string& words) const {
    return std::ranges::any_of(diagnostics(balance), [&](const std::string& sentence) {
      return sentence.find(words) != std::string::npos;
    });
  }
};

TEST(Remarks, SayWhatEveryEstimateRestsOn) {
  const Found found;
  EXPECT_EQ(diagnostics(found.balance).size(), 1U);
  EXPECT_TRUE(found.contains("couple unbalance"));
  EXPECT_TRUE(diagnostics({}).empty()) << "nothing is known";
}

Found not_separable(double least_km_h, double greatest_km_h) {
  Found found;
  for (Balance& wheel : found.balance) {
    wheel.force_state = ForceState::kNotSeparable;
    wheel.least_speed_m_s = least_km_h / 3.6;
    wheel.greatest_speed_m_s = greatest_km_h / 3.6;
  }
  return found;
}

TEST(Remarks, SayOnceThatTheSpeedsDoNotSeparate) {
  const Found found = not_separable(110.0, 130.0);
  EXPECT_TRUE(found.contains("not separable: 110–130 km/h"));
  EXPECT_EQ(diagnostics(found.balance).size(), 3U);
}

TEST(Remarks, SayUnbalanceAloneAndForceOfEachWheel) {
  Found found;
  found.balance[1].wheel = 1;
  found.balance[1].force_state = ForceState::kSeparated;
  found.balance[1].alone_g = 20.04;
  found.balance[1].sigma_alone_g = 1.26;
  found.balance[1].force_n = 48.0;
  found.balance[1].sigma_force_n = 4.6;
  EXPECT_TRUE(found.contains("alone and tyre's force: front_right 20.0 ± 1.3 g and 48 ± 5 N"));
  EXPECT_FALSE(found.contains("front_left"));
}

/// Forces of one road: their weight grows as the speed.
std::vector<FirstOrderForce> at(const std::vector<double>& speeds_km_h) {
  std::vector<FirstOrderForce> forces;
  for (const double km_h : speeds_km_h) forces.push_back({km_h / 3.6 / 0.3, 0.0, 1.0 / km_h});
  return forces;
}

TEST(Remarks, SayAtWhichSpeedsToDriveSoThatTheyDo) {
  EXPECT_TRUE(not_separable(110.0, 130.0).contains("Drive once more as long as this at 80 km/h or slower"));
  EXPECT_TRUE(not_separable(90.0, 130.0).contains("at 80 km/h or slower"));
  EXPECT_TRUE(not_separable(60.0, 70.0).contains("at 110 km/h or faster"));
  // As long as at the two ends of what was driven: twice one of them.
  for (const std::vector<double>& driven :
       {std::vector<double>{110, 130, 80, 80}, {90, 130, 80, 80}, {60, 70, 110, 110}, {60, 70, 130, 130}}) {
    EXPECT_FALSE(fit_first_order(at({driven[0], driven[1]})).separable) << driven[0];
    EXPECT_TRUE(fit_first_order(at(driven)).separable) << driven[0];
  }
}

}  // namespace
}  // namespace roadbalance
