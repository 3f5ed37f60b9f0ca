#include "host/identify/drive_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/bus/codec.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

std::string demo_toml() {
  return test::read_source("sim/demo/vehicle.toml");
}

std::string without(std::string text, const std::string& key_value, const std::string& instead) {
  for (std::size_t at; (at = text.find(key_value)) != std::string::npos;)
    text.replace(at, key_value.size(), instead);
  return text;
}

/// `seconds` of wheels turning at `omega` and nothing else.
void drive(DriveEstimator& estimator, const VehicleConfig& vehicle, double omega, int seconds) {
  ScanBlock block;
  block.period_ps = 500'000'000;
  for (std::int64_t number = 0; number < 100 * seconds; ++number)
    for (const auto& node : vehicle.node) {
      block.header = {node.id, 1, number + 1, number * kScansPerBlock, kScansPerBlock, number * 10'000'000};
      for (int row = 0; row < kScansPerBlock; ++row)
        for (int line = 0; line < kEncoderLines; ++line) {
          const double angle = omega * static_cast<double>(number * kScansPerBlock + row) / 2000.0;
          auto* channel = &block.counts[static_cast<std::size_t>(row)]
                                       [static_cast<std::size_t>(kAccelerations + 2 * line)];
          channel[0] = static_cast<std::int32_t>(std::lround(kFullScaleCounts * std::sin(angle)));
          channel[1] = static_cast<std::int32_t>(std::lround(kFullScaleCounts * std::cos(angle)));
        }
      SealedBlock sealed;
      seal(block, sealed);
      estimator.consume(sealed);
    }
}

TEST(DriveEstimator, SaysThatTheSensorsDoNotSuffice) {
  const auto vehicle =
      VehicleConfig::parse(without(demo_toml(), "direction = [0, 0, 1]", "direction = [0, 1, 0]"), "t");
  DriveEstimator estimator(vehicle);
  EXPECT_NE(estimator.obstacle().find("heave"), std::string::npos) << estimator.obstacle();
  drive(estimator, vehicle, 100.0, 1);
  EXPECT_EQ(estimator.estimate().identification.state, Unknown::kUnfitVehicle);
}

TEST(DriveEstimator, SaysThatTheCarWasTooSlow) {
  const auto vehicle = VehicleConfig::parse(demo_toml(), "t");
  DriveEstimator estimator(vehicle);
  EXPECT_EQ(estimator.estimate().balance[0].state, Unknown::kTooShort);
  drive(estimator, vehicle, 0.8 * vehicle.drive.least_speed_m_s / 0.30, 20);
  EXPECT_EQ(estimator.estimate().identification.state, Unknown::kTooSlow);
}

TEST(DriveEstimator, SaysThatNoEncoderGivesAnAngle) {
  const auto vehicle = VehicleConfig::parse(demo_toml(), "t");
  DriveEstimator estimator(vehicle);
  ScanBlock silent;  // references are 0
  silent.period_ps = 500'000'000;
  for (std::int64_t number = 0; number < 600; ++number)
    for (const auto& node : vehicle.node) {
      silent.header = {node.id, 1, number + 1, number * kScansPerBlock, kScansPerBlock, number * 10'000'000};
      SealedBlock sealed;
      seal(silent, sealed);
      estimator.consume(sealed);
    }
  EXPECT_EQ(estimator.estimate().identification.state, Unknown::kNoReference);
  EXPECT_NE(estimator.obstacle().find("front_left"), std::string::npos) << estimator.obstacle();
}

TEST(DriveEstimator, ClaimsNothingOfACarThatNothingShakes) {
  const auto vehicle = VehicleConfig::parse(demo_toml(), "t");
  DriveEstimator estimator(vehicle);
  drive(estimator, vehicle, 100.0, 80);
  EXPECT_EQ(estimator.estimate().identification.sections, 7);
  EXPECT_EQ(estimator.estimate().identification.state, Unknown::kIllConditioned);
}

}  // namespace
}  // namespace roadbalance
