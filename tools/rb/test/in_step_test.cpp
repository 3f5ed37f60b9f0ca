// Two front wheels that turn in step: hub sensors tell them apart, the body does not.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "common/record/record_writer.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/epoch_packer.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "sim/front_end.hpp"
#include "sim/truth.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

/// The demo car at 500 scans a second, its front wheels of one radius to 10 ppm, the rear wheels of others.
VehicleConfig car(bool hub_sensors) {
  std::string text = test::read_source("sim/demo/vehicle.toml");
  text = test::replaced(text, "\nrate_hz = 2000", "\nrate_hz = 500");
  text = test::replaced(text, "\ncutoff_hz = 200", "\ncutoff_hz = 60");
  const auto radius = [&](const std::string& wheel, const std::string& metres) {
    const auto at = text.find("rolling_radius_m = 0.30", text.find("name = \"" + wheel + "\""));
    text.replace(at, std::string("rolling_radius_m = 0.30").size(), "rolling_radius_m = " + metres);
  };
  radius("front_right", "0.300003");
  radius("rear_left", "0.3009");
  radius("rear_right", "0.2993");
  if (!hub_sensors)
    for (const char* wheel : {"fl", "fr", "rl", "rr"}) {
      const std::string name = std::string("name = \"") + wheel + "_carrier_z\"";
      text = test::replaced(text, name, name + "\nrole = \"unused\"");
    }
  return VehicleConfig::parse(text, "vehicle.toml");
}

class InStep : public testing::Test {
 protected:
  /// Drives 200 s and records it.
  void drive(const VehicleConfig& vehicle, double rolling_radius_spread) {
    std::ofstream(scenario_) << test::replaced(test::read_source("sim/demo/scenario.toml"),
                                               "rolling_radius = 0.003",
                                               "rolling_radius = " + std::to_string(rolling_radius_spread));
    RecordWriter writer({.folder = record_});
    for (const NodeConfig& node : vehicle.node) {
      const auto device =
          sim::open_sim_front_end({scenario_ + "?seed=4&seconds=200&rate=max", vehicle, node});
      pack_epoch(*device, vehicle, node, node.id,
                 [&](const SealedBlock& block) { writer.append(block, 1000); });
    }
    writer.close();
    found_ = identify_record(record_);
    truth_ = sim::truth_of(scenario_, 4, vehicle);
  }
  /// Every wheel, each no further off than `most` of its unbalance, and all together as their standard
  /// deviations say: eight squares add to chi^2 of 8, which is below 20.09 in 99 of 100 drives.
  void expect_all_found(double most) {
    double squares = 0.0;
    for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
      const Balance& balance = found_.estimate.balance[wheel];
      ASSERT_EQ(balance.state, Unknown::kNone) << kWheelNames[wheel];
      const auto& truth = truth_.wheel[wheel];
      const double off_g = balance.unbalance_g - truth.unbalance_g;
      const double off_rad = std::remainder(balance.angle_rad - truth.angle_deg * std::numbers::pi / 180.0,
                                            2.0 * std::numbers::pi);
      std::printf("%s: %.1f g off by %.2f +- %.2f g, %.2f +- %.2f deg\n", kWheelNames[wheel],
                  truth.unbalance_g, off_g, balance.sigma_g, off_rad * 180.0 / std::numbers::pi,
                  balance.sigma_rad * 180.0 / std::numbers::pi);
      EXPECT_LT(std::abs(off_g), most * truth.unbalance_g) << kWheelNames[wheel];
      EXPECT_LT(std::abs(off_rad), most) << kWheelNames[wheel];
      squares += std::pow(off_g / balance.sigma_g, 2) + std::pow(off_rad / balance.sigma_rad, 2);
    }
    EXPECT_LT(squares, 20.09);
  }
  void expect_refused_by_the_command() {
    const auto [code, output, log] = test::run_rb({"identify", record_}, folder_ / "rb.log");
    std::printf("%s%s", log.c_str(), output.c_str());
    EXPECT_NE(log.find("front_left and front_right turned in step"), std::string::npos) << log;
    for (const char* words : {"take a bend or change lanes", "fit sensors to their carriers"})
      EXPECT_NE(log.find(words), std::string::npos) << log;
    EXPECT_NE(output.find("front left:  not known: it turns in step with another wheel"), std::string::npos)
        << output;
  }

  const test::TemporaryDirectory folder_;
  const std::string record_ = folder_ / "record", scenario_ = folder_ / "scenario.toml";
  RecordedEstimate found_;
  sim::Truth truth_;
};

TEST_F(InStep, IsNoObstacleWithSensorsOnTheCarriers) {
  drive(car(true), 0.0);
  expect_all_found(0.10);
  EXPECT_EQ(found_.refusal, "");
}

TEST_F(InStep, IsRefusedWithTheBodyAloneAndTheHintSaysHowToGoOn) {
  drive(car(false), 0.0);
  EXPECT_EQ(found_.estimate.balance[0].state, Unknown::kInStep);
  EXPECT_EQ(found_.estimate.balance[1].state, Unknown::kInStep);
  EXPECT_EQ(found_.estimate.balance[2].state, Unknown::kNone);
  EXPECT_EQ(found_.estimate.balance[3].state, Unknown::kNone);
  expect_refused_by_the_command();
}

TEST_F(InStep, TheHintIsTrueOnceThePhasesDriftTheBodyTellsEveryWheel) {
  drive(car(false), 0.003);
  expect_all_found(0.5);
  EXPECT_EQ(found_.refusal.find("in step"), std::string::npos) << found_.refusal;
}

}  // namespace
}  // namespace roadbalance
