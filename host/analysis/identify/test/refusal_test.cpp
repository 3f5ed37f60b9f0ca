#include "host/analysis/identify/refusal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "common/test/source.hpp"

namespace roadbalance {
namespace {

using Kind = UncertainQuantity::Kind;

/// Result of a drive with a car that is as vehicle.toml has it, but for what a test adds.
struct Drive {
  VehicleConfig vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  CarPrior prior = CarPrior::of(vehicle);
  std::optional<PosteriorCar> car = PosteriorCar{};
  Drive() { add(Kind::kParameter, kSpring, prior.value(kSpring), 0.5); }
  void add(Kind kind, Eigen::Index index, double value, double sigmas) {
    car->deviations.push_back({{kind, index}, value, 0.01 * value, sigmas});
  }
  std::string refused() const { return refusal(car, prior, vehicle); }
  bool tells(const std::string& words) const {
    return std::ranges::any_of(remarks_on_deviations(car, prior, vehicle),
                               [&](const std::string& s) { return s.find(words) != std::string::npos; });
  }
};

TEST(Refusal, IsNoneOfACarThatIsAsItIsTakenFor) {
  const Drive drive;
  EXPECT_EQ(drive.refused(), "");
  EXPECT_TRUE(remarks_on_deviations(drive.car, drive.prior, drive.vehicle).empty());
}

TEST(Refusal, ScaleIsSaidWithWhatMassesAndGainsAreGoodTo) {
  PosteriorCar car;
  car.mass_scale_sigma = 0.0123;
  car.gain_scale_sigma = 0.004;
  EXPECT_NE(remark_on_scale(car).find("masses (± 1.2 %) and the sensors' gains (± 0.4 %) in vehicle.toml"),
            std::string::npos);
}

TEST(Refusal, AsksForMoreWhereADriveTellsNothing) {
  Drive drive;
  drive.car.reset();
  EXPECT_NE(drive.refused().find("rougher road"), std::string::npos);
  EXPECT_TRUE(remarks_on_deviations(drive.car, drive.prior, drive.vehicle).empty());
}

TEST(Refusal, NamesTheOneThatIsFarthestOff) {
  Drive drive;
  drive.add(Kind::kGain, 0, 1.03, 5.5);
  drive.add(Kind::kParameter, kDamper + 2, 5200.0, -6.2);
  const std::string refused = drive.refused();
  EXPECT_EQ(refused.find("rear_left damper: the drive says 5200 ± 52 N s/m and vehicle.toml"), 0U) << refused;
  EXPECT_NE(refused.find("6 times as far apart"), std::string::npos) << refused;
  EXPECT_EQ(refused.find("too much"), std::string::npos) << refused;
  EXPECT_TRUE(remarks_on_deviations(drive.car, drive.prior, drive.vehicle).empty());
}

TEST(Refusal, IsARemarkBelowItsBound) {
  Drive drive;
  drive.add(Kind::kGain, 1, 0.96, -4.0);
  EXPECT_EQ(drive.refused(), "");
  EXPECT_TRUE(drive.tells("it seems to read 4.0 ± 1.0 % too little"));
  drive.car->deviations.back().sigmas = -3.4;
  EXPECT_FALSE(drive.tells("too little"));
}

// Friction is nothing that vehicle.toml has: what it is said to be within, a strut in need of repair may be.
TEST(Refusal, TellsOfDryFrictionThatIsCertain) {
  Drive drive;
  drive.add(Kind::kFriction, 3, 100.0, 2.0);
  EXPECT_TRUE(drive.tells("rear_right: its strut seems to have a dry friction of 100 ± 1 N"));
  drive.car->deviations.back().sigma = 40.0;
  EXPECT_FALSE(drive.tells("friction"));
}

}  // namespace
}  // namespace roadbalance
