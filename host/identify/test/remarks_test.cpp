#include "host/identify/remarks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace roadbalance {
namespace {

struct Found {
  Identification identification;
  std::array<Balance, kWheels> balance{};
  Found() {
    identification.state = Unknown::kNone;
    for (Balance& wheel : balance) wheel.state = Unknown::kNone;
  }
  bool says(const std::string& words) const {
    return std::ranges::any_of(remarks(identification, balance), [&](const std::string& sentence) {
      return sentence.find(words) != std::string::npos;
    });
  }
};

TEST(Remarks, SayWhatEveryEstimateRestsOn) {
  const Found found;
  EXPECT_EQ(remarks(found.identification, found.balance).size(), 2U);
  EXPECT_TRUE(found.says("rests on the wheels' masses"));
  EXPECT_TRUE(found.says("couple unbalance"));
  EXPECT_TRUE(remarks(Identification{}, {}).empty()) << "nothing is known";
}

TEST(Remarks, SayThatMassesDoNotFit) {
  Found found;
  found.identification.mass_share[0] = -0.05;
  found.identification.sigma_mass_share[0] = 0.03;
  EXPECT_FALSE(found.says("masses seem"));
  EXPECT_EQ(misfitting(found.identification), "");
  found.identification.sigma_mass_share[0] = 0.012;
  EXPECT_TRUE(found.says("masses seem 5 ± 1 % smaller than mass_kg"));
  EXPECT_EQ(misfitting(found.identification), "all wheels together");
}

TEST(Remarks, NameTheWheelThatDoesNotFit) {
  Found found;
  found.identification.misfit_chance[1 + 2] = 1e-5;
  found.identification.mass_share[1 + 2] = 0.01;
  found.identification.sigma_mass_share[1 + 2] = 0.02;
  EXPECT_TRUE(found.says("rear_left: one linear car does not fit"));
  EXPECT_FALSE(found.says("its mass seems"));
  EXPECT_EQ(misfitting(found.identification), "rear_left");
  found.identification.mass_share[1 + 2] = 0.09;
  EXPECT_TRUE(found.says("its mass seems 9 ± 2 % larger"));
}

TEST(Remarks, SayThatTheBodyDoesNotFit) {
  Found found;
  found.identification.misfit_chance[0] = 1e-9;
  EXPECT_TRUE(found.says("heave, roll and pitch do not fit"));
}

TEST(Remarks, SayOnceThatTheSpeedsDoNotSeparate) {
  Found found;
  for (Balance& wheel : found.balance) {
    wheel.force_state = ForceState::kNotSeparable;
    wheel.least_speed_m_s = 110.0 / 3.6;
    wheel.greatest_speed_m_s = 130.0 / 3.6;
  }
  EXPECT_TRUE(found.says("not separable: 110–130 km/h"));
  EXPECT_EQ(remarks(found.identification, found.balance).size(), 3U);
}

}  // namespace
}  // namespace roadbalance
