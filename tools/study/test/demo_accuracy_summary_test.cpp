#include <gtest/gtest.h>

#include "tools/study/demo_accuracy.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// A wheel of 20 g at 350 degrees, found with these errors; standard deviations 0.5 g, 1 degree.
Json wheel(double error_g, double error_deg, double tyre_error_part = 0.01) {
  double angle = 350.0 + error_deg;
  if (angle >= 360.0) angle -= 360.0;
  return {{"name", "front_left"},
          {"unbalance_g", 20.0 + error_g},
          {"angle_deg", angle},
          {"sigma_g", 0.5},
          {"sigma_deg", 1.0},
          {"tyre_stiffness_n_m", 2e5 * (1.0 + tyre_error_part)},
          {"sigma_tyre_stiffness_n_m", 1e3},
          {"truth_g", 20.0},
          {"truth_deg", 350.0},
          {"truth_tyre_stiffness_n_m", 2e5}};
}

/// 20 seeds of one wheel; of these, `outside` beyond two sigma in grams and degrees.
std::vector<Json> runs(int outside) {
  std::vector<Json> list;
  for (int i = 0; i < 20; ++i)
    list.push_back({{"seed", i}, {"wheels", Json::array({i < outside ? wheel(1.1, 2.1) : wheel(0.4, 0.9)})}});
  return list;
}

TEST(DemoAccuracySummary, AcceptsWhatIsNearAndHonest) {
  const Json summary = demo_accuracy_summary(runs(2));
  EXPECT_TRUE(summary["accepted"]) << summary.dump(1);
  EXPECT_EQ(summary["good_seeds"], 20);
  EXPECT_NEAR(summary["acceptance"][1]["value"], 2.0, 1e-9);  // 0.4 of 20 g, in percent
  EXPECT_NEAR(summary["acceptance"][2]["value"], 0.9, 1e-9);
  EXPECT_NEAR(summary["acceptance"][4]["value"], 90.0, 1e-9);  // 18 of 20
}

// 100 % within two sigma is as dishonest as 80 %: sigmas too large or too small.
TEST(DemoAccuracySummary, RefusesSigmasThatAreTooLargeOrTooSmall) {
  EXPECT_FALSE(demo_accuracy_summary(runs(0))["accepted"]);
  EXPECT_FALSE(demo_accuracy_summary(runs(4))["accepted"]);
}

TEST(DemoAccuracySummary, CountsASeedAsBadIfOneStrongWheelIsOut) {
  auto list = runs(2);
  list[5]["wheels"].push_back(wheel(2.1, 0.0));  // 10.5 %
  list[6]["wheels"].push_back(wheel(0.0, 6.5));
  const Json summary = demo_accuracy_summary(list);
  EXPECT_EQ(summary["good_seeds"], 18);
  EXPECT_TRUE(summary["acceptance"][0]["met"]);
  list[7]["wheels"].push_back(wheel(-2.1, 0.0));
  EXPECT_FALSE(demo_accuracy_summary(list)["acceptance"][0]["met"]);
}

TEST(DemoAccuracySummary, AngleErrorsGoThroughZeroTheShortWay) {
  const Json summary = demo_accuracy_summary({{{"seed", 1}, {"wheels", Json::array({wheel(0.0, 15.0)})}}});
  EXPECT_NEAR(summary["seeds"][0]["wheels"][0]["error_deg"], 15.0, 1e-9);
}

TEST(DemoAccuracySummary, AWheelNotIdentifiedIsOutsideEverything) {
  auto list = runs(2);
  for (int i = 0; i < 3; ++i) {
    Json unknown = wheel(0.0, 0.0);
    for (const char* key : {"unbalance_g", "angle_deg", "sigma_g", "sigma_deg"}) unknown[key] = nullptr;
    list[static_cast<std::size_t>(10 + i)]["wheels"] = Json::array({unknown});
  }
  const Json summary = demo_accuracy_summary(list);
  EXPECT_EQ(summary["good_seeds"], 17);
  EXPECT_NEAR(summary["acceptance"][4]["value"], 75.0, 1e-9);
}

}  // namespace
}  // namespace roadbalance
