// The chain from the simulated car to the estimate against the truth: a wrong sign, axis, datum or unit
// between any two of its rooms shows here.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "embedded/demo_vehicle.hpp"
#include "tools/study/demo_accuracy.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// The printed deviations come from ten groups and are themselves uncertain to a quarter; beyond five of them
/// an honest estimate lies less than once in a thousand, one with a wrong sign or datum by dozens.
constexpr double kMostSigmas = 5.0;

class DemoAccuracyRun : public testing::TestWithParam<std::uint64_t> {};

TEST_P(DemoAccuracyRun, EstimatesLieAtTheTruth) {
  const Json run = demo_accuracy_run(GetParam(), 160.0);
  ASSERT_EQ(run["wheels"].size(), 4U);
  int strong = 0;
  for (const Json& wheel : run["wheels"]) {
    ASSERT_TRUE(wheel["unbalance_g"].is_number() && wheel["tyre_stiffness_n_m"].is_number()) << wheel;
    const double truth_g = wheel["truth_g"];
    const double grams = std::abs(wheel["unbalance_g"].get<double>() - truth_g);
    const double degrees =
        std::abs(std::remainder(wheel["angle_deg"].get<double>() - wheel["truth_deg"].get<double>(), 360.0));
    if (truth_g >= 20.0) {  // the project's acceptance
      ++strong;
      EXPECT_LE(grams, 0.10 * truth_g) << wheel;
      EXPECT_LE(degrees, 6.0) << wheel;
    }
    EXPECT_LE(grams, kMostSigmas * wheel["sigma_g"].get<double>()) << wheel;
    EXPECT_LE(degrees, kMostSigmas * wheel["sigma_deg"].get<double>()) << wheel;
    const double stiffness =
        std::abs(wheel["tyre_stiffness_n_m"].get<double>() - wheel["truth_tyre_stiffness_n_m"].get<double>());
    EXPECT_LE(stiffness, kMostSigmas * wheel["sigma_tyre_stiffness_n_m"].get<double>()) << wheel;
    // Five deviations must not be as much as a wrong sign.
    EXPECT_LT(kMostSigmas * wheel["sigma_deg"].get<double>(), 45.0) << wheel;
  }
  EXPECT_EQ(strong, 2);
}

INSTANTIATE_TEST_SUITE_P(Seeds, DemoAccuracyRun, testing::Values(1, 2));

// Omitting a datum, or its sign, must cost more than the 6 degrees above.
TEST(DemoVehicle, HasAnotherDatumThanZeroAtEveryWheel) {
  const auto vehicle = VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml");
  for (const WheelConfig& wheel : vehicle.wheel)
    EXPECT_GT(std::abs(std::remainder(wheel.encoder.datum_rad, std::numbers::pi)), 0.2) << wheel.name;
}

}  // namespace
}  // namespace roadbalance
