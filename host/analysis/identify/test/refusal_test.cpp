#include "host/analysis/identify/refusal.hpp"

#include <gtest/gtest.h>

#include "common/test/source.hpp"

namespace roadbalance {
namespace {

/// Result of a drive for a car that is as vehicle.toml has it.
struct Drive {
  Priors priors = Priors::of(VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml")));
  UnknownVector x = UnknownVector::Zero();
  EstimateCovariance covariance;
  Drive() {
    x.head<kEstimatedUnbalance>() = priors.value.segment<kEstimatedUnbalance>(kSpring);
    covariance.suspension = {.condition = 4.0, .margin = 400.0, .weakest = kEstimatedStabiliser};
  }
  bool is_refused_for(const std::string& words) const {
    return refusal(x, covariance, priors).find(words) != std::string::npos;
  }
};

TEST(Refusal, IsNoneOfASoundDrive) {
  const Drive drive;
  EXPECT_EQ(refusal(drive.x, drive.covariance, drive.priors), "");
}

TEST(Refusal, SaysWhatTheDriveTellsLeastAndWhereToDrive) {
  Drive drive;
  drive.covariance.suspension.margin = 3.1;
  EXPECT_EQ(refusal(drive.x, drive.covariance, drive.priors), "");
  drive.covariance.suspension.margin = 2.9;
  EXPECT_TRUE(drive.is_refused_for("the front stabiliser least"));
  EXPECT_TRUE(drive.is_refused_for("condition number 4"));
  EXPECT_TRUE(drive.is_refused_for("left and right wheels meet bumps of their own"));
}

TEST(Refusal, NamesWhatIsNotPlausible) {
  Drive drive;
  drive.x(kEstimatedStabiliser + 1) *= 0.1;  // may truly be weak
  EXPECT_EQ(implausible(drive.x, drive.priors), std::nullopt);
  drive.x(kEstimatedDamper + 2) *= 2.1;
  EXPECT_TRUE(drive.is_refused_for("rear_left damper: the drive says 3360 N s/m and vehicle.toml 1600"));
  drive.x(kEstimatedDamper + 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(implausible(drive.x, drive.priors), kEstimatedDamper + 2);
}

TEST(Refusal, AsksForMoreWhereADriveTellsNothing) {
  const Drive drive;
  EXPECT_NE(refusal(std::nullopt, std::nullopt, drive.priors).find("rougher road"), std::string::npos);
  EXPECT_NE(refusal(drive.x, std::nullopt, drive.priors).find("drive on"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
