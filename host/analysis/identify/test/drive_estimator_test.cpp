#include "host/analysis/identify/drive_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
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
  EXPECT_NE(estimator.refusal().find("heave"), std::string::npos) << estimator.refusal();
  drive(estimator, vehicle, 100.0, 1);
  EXPECT_EQ(estimator.estimate().identification.state, Unknown::kUnfitVehicle);
}

TEST(DriveEstimator, SaysThatACarOfAnotherFormIsNotIdentified) {
  std::string text = demo_toml();
  const auto begin = text.find("kind = \"seven_dof\""), end = text.find("[filter]");
  text.replace(begin, end - begin, "kind = \"description\"\nfile = \"three_wheeler.toml\"\n");
  const auto vehicle = VehicleConfig::parse(text, "t");
  DriveEstimator estimator(vehicle);
  EXPECT_NE(estimator.refusal().find("identified as \"seven_dof\" only"), std::string::npos)
      << estimator.refusal();
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
  EXPECT_NE(estimator.refusal().find("front_left"), std::string::npos) << estimator.refusal();
}

/// Refusal of the demo car without encoders, whose front node hears these signals of its bus.
std::string refusal_with(const std::string& signals) {
  const std::regex encoder(R"(node = .*\nline = .*\n\[wheel\.encoder\]\n[^\[]*)");
  std::string text = std::regex_replace(demo_toml(), encoder, "\n");
  if (!signals.empty())
    text.insert(text.find("[[node.channel]]"),
                "[[node.can]]\ninterface = \"can0\"\nrole = \"vehicle\"\ndbc = \"car.dbc\"\nsignal = [" +
                    signals + "]\n");
  DriveEstimator estimator(VehicleConfig::parse(text, "t"));
  for (const Balance& balance : estimator.estimate().balance) EXPECT_EQ(balance.state, Unknown::kNoReference);
  return estimator.refusal();
}

TEST(DriveEstimator, SaysThatNeitherSpeedNorCountOfABusIsAnAngle) {
  EXPECT_NE(refusal_with("").find("no wheel has an encoder"), std::string::npos) << refusal_with("");
  const std::string speed =
      R"({name = "a", message = "M", signal = "S", quantity = "wheel_speed", wheel = "front_left"})";
  const std::string refusal = refusal_with(speed);
  EXPECT_EQ(refusal.find("front_left: the bus tells the wheel's speed only"), 0U) << refusal;
  EXPECT_NE(refusal.find("carries no angle"), std::string::npos) << refusal;
  const std::string both = refusal_with(
      speed +
      R"(, {name = "b", message = "M", signal = "C", quantity = "pulse_counter", wheel = "rear_left"})");
  EXPECT_NE(both.find("rear_left: the bus counts pulses but sends no zero mark"), std::string::npos) << both;
  EXPECT_NE(both.find("front_left"), std::string::npos) << both;
}

TEST(DriveEstimator, ClaimsNothingOfACarThatNothingShakes) {
  const auto vehicle = VehicleConfig::parse(demo_toml(), "t");
  DriveEstimator estimator(vehicle);
  drive(estimator, vehicle, 100.0, 80);
  EXPECT_EQ(estimator.estimate().identification.sections,
            8);  // of 10 s, each begun in the last second of another
  EXPECT_EQ(estimator.estimate().identification.state, Unknown::kIllConditioned);
  EXPECT_NE(estimator.refusal().find("drive on a rougher road"), std::string::npos) << estimator.refusal();
}

}  // namespace
}  // namespace roadbalance
