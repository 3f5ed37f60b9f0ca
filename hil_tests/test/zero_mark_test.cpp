#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "common/config/vehicle_config.hpp"
#include "common/text/format.hpp"
#include "hil_tests/test/operating_fixture.hpp"
#include "sim/drawn_car.hpp"

namespace roadbalance {
namespace {

using test::Program;

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kRadius_m = 0.30, kTurning_s = 2.5, kStanding_s = 5.0;
constexpr int kTurns = 2;  ///< between two stands, so that the wheel stands alike each time

/// A wheel that is turned on and let stand, over and over.
std::string stop_and_go() {
  const double speed_km_h = 3.6 * kTurns * 2.0 * std::numbers::pi * kRadius_m / kTurning_s;
  std::string text = "[drive]\nramp_s = 0.5\nwander_km_h = 0.0\n";
  const auto plateau = [&](double speed, double seconds) {
    text += format("[[drive.plateau]]\nspeed_km_h = %.9f\nseconds = %.1f\n", speed, seconds);
  };
  plateau(0.0, 2.0);
  for (int k = 0; k < 12; ++k) {
    plateau(speed_km_h, kTurning_s);
    plateau(0.0, kStanding_s);
  }
  std::string scenario = test::read_source("sim/demo/scenario.toml");
  const std::size_t from = scenario.find("[drive]"), to = scenario.find("[road]");
  scenario.replace(from, to - from, text);
  return test::replaced(scenario, "rolling_radius = 0.003", "rolling_radius = 0.0");
}

/// The front left wheel of the demonstration car, whose mark fires at 30 degrees.
TEST_F(Operating, FindsTheZeroMarkOfAWheelThatIsTurnedByHand) {
  const std::filesystem::path scenario = work.path() / "by-hand.toml";
  std::ofstream(scenario) << stop_and_go();
  const VehicleConfig vehicle =
      VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "vehicle.toml");
  const auto car = sim::draw_car(sim::Scenario::read(scenario.string(), vehicle), 1, vehicle);
  ASSERT_EQ(car.rolling_radius_m[0], kRadius_m);
  // The angle as a person beside the car sees it.
  const std::string seen = format("%.1f°", std::remainder(car.initial_angle_rad[0] * kDegrees, 360.0));

  Program recorder = operated_recorder();
  std::vector<Program> nodes;
  for (const std::string name : {"front", "rear"})
    nodes.emplace_back(
        "rb-node",
        std::vector<std::string>{"--url", url, "--vehicle", (vehicles / "car.toml").string(), "--node", name,
                                 "--front-end", "sim:" + scenario.string() + "?seed=1&rate=1", "--stay"});
  start("jacked up");
  const auto command = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"configure", "reading", "front_left"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    arguments.insert(arguments.end(), {"--url", url});
    return test::run("rb", arguments, 30) == 0;
  };
  ASSERT_TRUE(command({}));
  EXPECT_FALSE(command({"10"})) << "an hour or degrees?";
  // Refused while it turns, and until its mark has fired again.
  for (int counted = 0; counted < 2; ++counted)
    ASSERT_TRUE(test::wait_until([&] { return command({seen}); }, 60)) << counted;
  Answer last;
  ASSERT_TRUE(test::wait_until(
      [&] {
        last = ask(
            Operation::kReading, "",
            {.channel = 0, .value = {std::remainder(car.initial_angle_rad[0], 2.0 * std::numbers::pi), 1.0}});
        return last.state == AnswerState::kDone;
      },
      60));
  EXPECT_NE(last.text.find("3 readings"), std::string::npos) << last.text;
  // A ring of 96 teeth locates a standing wheel to a tooth, evenly: sigma pitch / sqrt(12 * 3), at most half
  // a pitch.
  const double pitch_deg = 360.0 / 96.0;
  EXPECT_NEAR(last.value[0] * kDegrees, 30.0, 0.5 * pitch_deg + 0.5) << last.text;
  EXPECT_NEAR(last.value[1] * kDegrees, pitch_deg / std::sqrt(36.0), 0.01);
  stop();
  // The nodes leave with the recording, and are back some moments later: the recorder waits for them.
  EXPECT_EQ(test::run("rb",
                      {"configure", "datum", "front_left", format("%.2f", last.value[0] * kDegrees), "0.7",
                       "--url", url},
                      60),
            0);
  const VehicleConfig found = VehicleConfig::read_file((vehicles / "car.toml").string());
  EXPECT_NEAR(found.wheel[0].encoder.datum_rad, last.value[0], 0.01 / kDegrees);
}

}  // namespace
}  // namespace roadbalance
