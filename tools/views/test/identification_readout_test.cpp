// `rb identify`'s output of the suspension and of the ellipses, as text and as JSON.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tools/views/identification_json.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/wheels_json.hpp"

namespace roadbalance {
namespace {

TEST(IdentificationLine, SaysHowFarItIsFromAnEstimate) {
  Identification identification;
  EXPECT_EQ(identification_line(identification),
            "suspension: not known: not enough driving at a steady speed yet");
  identification.sections = 4;
  identification.seconds_used = 40.0;
  identification.seconds_needed = 60.0;
  EXPECT_EQ(identification_line(identification),
            "suspension: not known: 40 s of steady driving so far, 60 needed");
}

TEST(IdentificationLine, ClaimsNoTyreExactly) {
  Identification identification;
  identification.state = Unknown::kNone;
  identification.seconds_used = 3600.0;
  identification.tyre_n_m.fill(200'000.0);
  identification.sigma_tyre_n_m = {100.0, 1'000.0, 2'600.0, 400.0};
  EXPECT_EQ(identification_line(identification),
            "from 3600 s of driving; tyres 200 ± 1 200 ± 1 200 ± 3 200 ± 1 kN/m");
}

TEST(IdentificationLine, SaysWhatIsMissingOrWhoSaysIt) {
  Identification identification;
  identification.state = Unknown::kIllConditioned;
  const std::string begin = "suspension: not known: the drive does not determine it";
  EXPECT_EQ(identification_line(identification), begin + ": rb identify says what is missing");
  EXPECT_EQ(identification_line(identification, "drive on"), begin + ": drive on");
  identification.state = Unknown::kTooSlow;
  EXPECT_EQ(identification_line(identification, "drive on"),
            "suspension: not known: the car never went fast enough");
  Balance balance;
  balance.state = Unknown::kIllConditioned;
  EXPECT_EQ(balance_line(balance), "front left:  not known: the drive does not determine it");
}

Identification suspension() {
  Identification found;
  found.state = Unknown::kNone;
  found.spring_n_m = {30'120.0, 29'960.0, 25'000.0, 25'000.0};
  found.sigma_spring_n_m = {160.0, 4.0, 50.0, 1'234.0};
  found.damper_n_s_m = {1'440.4, 1'500.0, 1'300.0, 1'300.0};
  found.sigma_damper_n_s_m = {0.2, 4.6, 0.0, 15.0};
  found.stabiliser_n_m = {12'000.0, 9'000.0};
  found.sigma_stabiliser_n_m = {20.0, 230.0};
  return found;
}

TEST(SuspensionLines, ClaimNothingExactly) {
  const auto lines = suspension_lines(suspension());
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0],
            "springs 30.1 ± 0.2 30.0 ± 0.1 25.0 ± 0.1 25.0 ± 1.2 kN/m; dampers 1440 ± 1 1500 ± 5 1300 ± 1 "
            "1300 ± 15 N s/m");
  EXPECT_EQ(lines[1], "stabilisers 12.0 ± 0.1 9.0 ± 0.2 kN/m");
  EXPECT_TRUE(suspension_lines({}).empty());
  EXPECT_TRUE(std::isnan(shown_sigma(std::numeric_limits<double>::quiet_NaN(), 0.1)));
}

TEST(IdentificationJson, HoldsTheSuspensionAndWhatItRestsOn) {
  EXPECT_TRUE(suspension_json({}).is_null());
  EXPECT_EQ(speeds_json({}).dump(), "[]");
  Identification found = suspension();
  found.speed_class = {{25.0, 80.0}, {36.0, 79.0}};
  found.sigma_damper_n_s_m[1] = std::numeric_limits<double>::quiet_NaN();
  const auto suspended = suspension_json(found);
  EXPECT_EQ(suspended["spring_n_m"].size(), static_cast<std::size_t>(kWheels));
  EXPECT_EQ(suspended["spring_n_m"][3], (nlohmann::ordered_json{{"value", 25'000.0}, {"sigma", 1'234.0}}));
  EXPECT_EQ(suspended["damper_n_s_m"][1]["value"], 1'500.0);
  EXPECT_TRUE(suspended["damper_n_s_m"][1]["sigma"].is_null());
  EXPECT_EQ(suspended["stabiliser_n_m"][1]["sigma"], 230.0);
  EXPECT_EQ(speeds_json(found)[1]["speed_m_s"], 36.0);
  EXPECT_EQ(speeds_json(found)[1]["seconds"], 79.0);
}

TEST(WheelsJson, HoldTheEllipseAndWhetherAForceIsApart) {
  std::array<Balance, kWheels> balance;
  balance[0].state = Unknown::kNone;
  balance[0].covariance_g2 << 4.0, 1.0, 1.0, 9.0;
  balance[0].force_state = ForceState::kNotSeparable;
  balance[0].alone_g = 12.0;
  balance[0].sigma_alone_g = 9.0;
  balance[0].force_n = 20.0;
  balance[0].sigma_force_n = 30.0;
  const auto wheels = wheels_json({}, balance);
  EXPECT_EQ(wheels[0]["covariance_g2"].dump(), "[[4.0,1.0],[1.0,9.0]]");
  EXPECT_EQ(wheels[0]["force_state"], "not_separable");
  EXPECT_EQ(wheels[0]["alone_g"], 12.0) << "hardly known, and said with its ±";
  EXPECT_EQ(wheels[0]["sigma_alone_g"], 9.0);
  EXPECT_EQ(wheels[0]["force_n"], 20.0);
  EXPECT_EQ(wheels[0]["sigma_force_n"], 30.0);
  EXPECT_TRUE(wheels[1]["covariance_g2"].is_null());
  EXPECT_TRUE(wheels[1]["force_state"].is_null());
  EXPECT_TRUE(wheels[1]["alone_g"].is_null());
  EXPECT_TRUE(wheels[1]["force_n"].is_null());
}

}  // namespace
}  // namespace roadbalance
