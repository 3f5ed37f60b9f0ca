#include "tools/study/drift_cost.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// Two seeds whose four wheels changed by these means, plus and minus the same.
std::vector<Json> runs(double percent_a, double percent_b, double deg) {
  const auto run = [&](int seed, double percent) {
    Json wheels = Json::array();
    for (const double apart : {-1.0, 1.0, -0.5, 0.5})
      wheels.push_back({{"change_percent", percent + apart}, {"change_deg", deg - apart}});
    return Json{{"seed", seed}, {"wheels", wheels}};
  };
  return {run(1, percent_a), run(2, percent_b)};
}

TEST(DriftCost, MeansAreOverWheelsAndErrorsFromSeeds) {
  const Json summary = drift_cost_summary(runs(0.02, 0.06, 0.01));
  EXPECT_NEAR(summary["acceptance"][0]["value"].get<double>(), 0.04, 1e-12);
  // Two values 0.04 apart: deviation 0.04 / sqrt(2), of their mean 0.04 / 2.
  EXPECT_NEAR(summary["acceptance"][0]["standard_error"].get<double>(), 0.02, 1e-12);
  EXPECT_NEAR(summary["acceptance"][1]["value"].get<double>(), 0.01, 1e-12);
  EXPECT_TRUE(summary["accepted"].get<bool>());
}

TEST(DriftCost, IsNotMetByWhatIsTooMuchNorByWhatIsNotCertain) {
  EXPECT_FALSE(drift_cost_summary(runs(0.12, 0.12, 0.0))["accepted"].get<bool>());
  EXPECT_FALSE(drift_cost_summary(runs(0.0, 0.0, -0.06))["accepted"].get<bool>());
  EXPECT_FALSE(drift_cost_summary(runs(-0.05, 0.15, 0.0))["accepted"].get<bool>());  // 0.05 +- 0.1
}

TEST(DriftCost, IsNotMetWhereAWheelIsUnknownOrThereIsOneSeedOnly) {
  std::vector<Json> unknown = runs(0.0, 0.0, 0.0);
  unknown[1]["wheels"][2]["change_percent"] = nullptr;
  const Json summary = drift_cost_summary(unknown);
  EXPECT_FALSE(summary["accepted"].get<bool>());
  EXPECT_TRUE(summary["acceptance"][0]["value"].is_null());
  EXPECT_FALSE(drift_cost_summary({runs(0.0, 0.0, 0.0).front()})["accepted"].get<bool>());
}

}  // namespace
}  // namespace roadbalance
