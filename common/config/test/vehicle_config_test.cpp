#include "common/config/vehicle_config.hpp"

#include <cmath>
#include <numbers>
#include <regex>
#include <utility>

#include <gtest/gtest.h>

#include "common/config/section.hpp"
#include "common/config/test/refusal.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

using test::refusal;

std::string demo() {
  return test::read_source("sim/demo/vehicle.toml");
}

/// The demo vehicle with the first `from` replaced by `to`.
std::string changed(const std::string& from, const std::string& to) {
  std::string text = demo();
  const auto place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

TEST(VehicleConfig, ReadsTheDemoCar) {
  const auto v = VehicleConfig::parse(demo(), "vehicle.toml");
  EXPECT_EQ(v.text, demo());
  EXPECT_EQ(v.model.body_mass_kg, 1'300.0);
  EXPECT_EQ(v.model.axle[1].x_m, -1.45);
  EXPECT_EQ(v.model.axle[0].tyre_n_m, 215'000.0);
  EXPECT_EQ(v.wheel[2].name, "rear_left");
  EXPECT_EQ(v.wheel[2].mass_kg, 32.0);
  EXPECT_EQ(v.wheel[0].weight_radius_m, 0.19);
  EXPECT_EQ(v.wheel[0].encoder.pulses_per_turn, 96);
  EXPECT_NEAR(v.wheel[0].encoder.datum_rad, std::numbers::pi / 6.0, 1e-15);
  ASSERT_EQ(v.node.size(), 2U);
  EXPECT_EQ(v.node[1].id, 2);
  EXPECT_EQ(v.node[0].rate_hz, 2'000.0);
  ASSERT_EQ(v.node[0].channel.size(), 12U);
  const ChannelConfig& carrier = v.node[0].channel[2];
  EXPECT_EQ(carrier.name, "fl_carrier_z");
  EXPECT_EQ(carrier.mount, "front_left");
  EXPECT_EQ(carrier.direction, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(carrier.to_si(kFullScaleCounts / 2), 100.0);
  EXPECT_EQ(v.filter.order, 6);
  EXPECT_EQ(v.filter.cutoff_hz, 200.0);
  EXPECT_FALSE(v.road.measured);
  EXPECT_EQ(v.drive.identification_rate_hz, 500.0);
}

TEST(VehicleConfig, ReadsTheDemoCarWithACabinNode) {
  const auto v = VehicleConfig::read_file(test::source_path("sim/demo/vehicle-3-nodes.toml"));
  ASSERT_EQ(v.node.size(), 3U);
  EXPECT_EQ(v.node[2].name, "cabin");
  EXPECT_EQ(v.node[2].channel.size(), 12U);
  EXPECT_EQ(v.wheel_at(v.node[2], 0), nullptr);
}

TEST(VehicleConfig, FindsNodesAndWheels) {
  const auto v = VehicleConfig::parse(demo(), "vehicle.toml");
  EXPECT_EQ(v.node_named("rear").id, 2);
  EXPECT_THROW(v.node_named("roof"), ConfigError);
  EXPECT_EQ(v.node_with_id(1), &v.node[0]);
  EXPECT_EQ(v.node_with_id(3), nullptr);
  EXPECT_EQ(v.wheel_at(v.node[1], 1), &v.wheel[3]);
  EXPECT_EQ(v.wheel_at(v.node[1], 2), nullptr);
  EXPECT_EQ(v.wheel_named("rear_left"), &v.wheel[2]);
  EXPECT_EQ(v.wheel_named("spare"), nullptr);
  EXPECT_EQ(v.place_of(v.wheel[2]), 2);
}

TEST(VehicleConfig, TakesACarOfAnotherFormByItsDescription) {
  std::string text = demo();
  const auto begin = text.find("kind = \"seven_dof\""), end = text.find("[filter]");
  text.replace(begin, end - begin, "kind = \"description\"\nfile = \"three_wheeler.toml\"\n");
  EXPECT_EQ(VehicleConfig::parse(text, "vehicle.toml").model.description, "three_wheeler.toml");
  EXPECT_EQ(VehicleConfig::parse(demo(), "vehicle.toml").model.description, "");
}

TEST(VehicleConfig, TakesTheDampingOfTyres) {
  const auto damped = changed("tyre_n_m = 210000", "tyre_n_m = 210000\ntyre_damper_n_s_m = 120");
  const auto axle = VehicleConfig::parse(damped, "vehicle.toml").model.axle;
  EXPECT_EQ(axle[0].tyre_damper_n_s_m, 0.0);
  EXPECT_EQ(axle[1].tyre_damper_n_s_m, 120.0);
  EXPECT_EQ(axle[1].tyre_damper_sigma_n_s_m, 0.0);
}

TEST(VehicleConfig, TakesCalibrationAndDirectionOfAChannel) {
  const auto v = VehicleConfig::parse(
      changed("direction = [1, 0, 0]",
              "direction = [0.3, 0, -0.4]\ncalibration = {scale_m_s2_per_count = 1e-4, offset_counts = 12, "
              "delay_us = -3.5}"),
      "car.toml");
  const ChannelConfig& c = v.node[0].channel[0];
  EXPECT_LT((c.direction - Eigen::Vector3d(0.6, 0, -0.8)).norm(), 1e-15);
  EXPECT_NEAR(c.to_si(112.0), 0.01, 1e-15);
  EXPECT_NEAR(c.delay_s, -3.5e-6, 1e-15);
  EXPECT_EQ(v.node[0].channel[1].delay_s, 0.0);
}

TEST(VehicleConfig, TakesWhatIsKnownOfAnEncoder) {
  const auto v = VehicleConfig::parse(
      changed("datum_deg = 30", "datum_deg = 30\ndatum_sigma_deg = 0.5\nsteering_ratio = 0.0625"),
      "car.toml");
  EXPECT_NEAR(v.wheel[0].encoder.datum_sigma_rad, 0.5 * std::numbers::pi / 180, 1e-15);
  EXPECT_EQ(v.wheel[0].encoder.steering_ratio, 0.0625);
  EXPECT_EQ(v.wheel[1].encoder.datum_sigma_rad, 0.0);
  EXPECT_EQ(v.wheel[1].encoder.steering_ratio, 0.0);
}

const std::string kDriveShaft = R"(
[[rotor]]
name = "drive_shaft"
wheel = ["rear_left", "rear_right"]
ratio = 3.73
[[rotor.plane]]
name = "pinion_flange"
position_m = [-1.2, 0, -0.2]
weight_radius_m = 0.05
)";

TEST(VehicleConfig, TakesARotorThatWheelsTurn) {
  const auto v = VehicleConfig::parse(demo() + kDriveShaft, "car.toml");
  ASSERT_EQ(v.rotor.size(), 1U);
  const RotorConfig* const shaft = v.rotor_named("drive_shaft");
  ASSERT_NE(shaft, nullptr);
  EXPECT_EQ(shaft->wheel, (std::vector<int>{2, 3}));
  EXPECT_EQ(shaft->ratio, 3.73);
  ASSERT_EQ(shaft->plane.size(), 1U);
  EXPECT_EQ(shaft->plane[0].position_m, Eigen::Vector3d(-1.2, 0, -0.2));
  EXPECT_EQ(shaft->plane[0].weight_radius_m, 0.05);
  EXPECT_EQ(v.rotor_named("gearbox"), nullptr);
}

TEST(VehicleConfig, RefusesARotorThatNothingTurns) {
  const auto says = [](const std::string& from, const std::string& to) {
    std::string shaft = kDriveShaft;
    return refusal(demo() + shaft.replace(shaft.find(from), from.size(), to));
  };
  EXPECT_NE(says("\"rear_left\"", "\"fifth\"").find("wheel: \"fifth\" is no wheel with an encoder"),
            std::string::npos);
  EXPECT_NE(says("[\"rear_left\", \"rear_right\"]", "[]").find("wheel: missing"), std::string::npos);
  EXPECT_NE(says("ratio = 3.73", "ratio = 0").find("ratio: is 0"), std::string::npos);
  EXPECT_NE(says("drive_shaft", "front_left").find("name: \"front_left\" stands twice"), std::string::npos);
}

TEST(VehicleConfig, TakesMassesForKnownAsWellAsItSays) {
  const std::string exact = demo();
  EXPECT_EQ(VehicleConfig::parse(exact, "car.toml").wheel[2].mass_sigma_kg, 0.0);
  const auto v = VehicleConfig::parse(
      std::regex_replace(exact, std::regex("[a-z_]*sigma_(kg[_m2]*|n_s_m) = 0\n"), ""), "car.toml");
  EXPECT_DOUBLE_EQ(v.wheel[2].mass_sigma_kg, 0.02 * 32.0);
  EXPECT_DOUBLE_EQ(v.model.body_mass_sigma_kg, 0.03 * 1300.0);
  EXPECT_DOUBLE_EQ(v.model.pitch_inertia_sigma_kg_m2, 0.10 * 2200.0);
  EXPECT_DOUBLE_EQ(v.model.axle[0].tyre_damper_sigma_n_s_m, 50.0);
}

TEST(VehicleConfig, NamesFileLineKeyAndWhatIsAllowed) {
  struct Case {
    std::string from, to;    ///< change of the demo vehicle
    std::string line, says;  ///< where, and the words that follow "car.toml:LINE: "
  };
  const Case cases[] = {
      {"mass_kg = 34", "mass_g = 34000", "mass_g",
       "mass_g: unknown key (did you mean mass_kg?); allowed: a number 1 .. 1000"},
      {"mass_kg = 34", "mas_kg = 34", "mas_kg",
       "mas_kg: unknown key (did you mean mass_kg?); allowed: a number 1 .. 1000"},
      {"rotating_mass_kg = 26", "rotating_mass_kg = 35", "rotating_mass_kg = 35",
       "rotating_mass_kg: is 35; allowed: a number 1 .. 34"},
      {"spring_n_m = 22000", "sprig_n_m = 22000", "sprig_n_m",
       "sprig_n_m: unknown key (did you mean spring_n_m?); allowed: a number > 0"},
      {"spring_n_m = 22000", "sprung_load = 22000", "[model.front]",
       "spring_n_m: missing; allowed: a number"},
      {"datum_deg = 30", "datum_rad = 0.5", "datum_rad",
       "datum_rad: unknown key (did you mean datum_deg?); allowed here: pulses_per_turn, zero_mark, "},
      {"body_mass_kg = 1300", "body_mass_kg = 1300\ncolour = 1", "colour",
       "colour: unknown key; allowed here: kind, body_mass_kg, roll_inertia_kg_m2, pitch_inertia_kg_m2, "
       "body_mass_sigma_kg, roll_inertia_sigma_kg_m2, pitch_inertia_sigma_kg_m2, front, rear"},
      {"body_mass_kg = 1300", "body_mass_kg = -1300", "body_mass_kg",
       "body_mass_kg: is -1300; allowed: a number > 0"},
      {"body_mass_kg = 1300", "body_mass_kg = [0.1]", "body_mass_kg", "body_mass_kg: allowed: a number > 0"},
      {"body_mass_kg = 1300", "body_mass_kg = nan", "body_mass_kg",
       "body_mass_kg: is nan; allowed: a number > 0"},
      {"body_mass_kg = 1300", "body_mass_kg = \"heavy\"", "body_mass_kg",
       "body_mass_kg: is 'heavy'; allowed: a number > 0"},
      {"body_mass_kg = 1300", "", "[model]", "body_mass_kg: missing; allowed: a number > 0"},
      {"kind = \"seven_dof\"", "kind = \"bicycle\"", "bicycle",
       "kind: is 'bicycle'; allowed: seven_dof, description"},
      {"order = 6", "order = 13", "order = 13", "order: is 13; allowed: an integer 1 .. 12"},
      {"order = 6", "order = 5.5", "order = 5.5", "order: is 5.5; allowed: an integer 1 .. 12"},
      {"zero_mark = true", "zero_mark = 1", "zero_mark = 1", "zero_mark: is 1; allowed: true, false"},
      {"identification_rate_hz = 500", "identification_rate_hz = 600", "identification_rate_hz",
       "identification_rate_hz: must divide the nodes' rate_hz"},
      {"rate_hz = 2000", "rate_hz = 1000", "id = 2\nrate_hz", "rate_hz: must be the same for all nodes"},
      {"cutoff_hz = 200", "cutoff_hz = 1000", "id = 1\nrate_hz",
       "rate_hz: must be more than twice the filter's cutoff_hz"},
      {"weight_radius_m = 0.19", "weight_radius_m = 0.30", "weight_radius_m = 0.30",
       "weight_radius_m: must be less than rolling_radius_m"},
      {"name = \"front_right\"", "name = \"front_left\"", "plane = \"inner\"\n\n[[wheel]]\nname",
       "name: \"front_left\" stands twice"},
      {"node = \"front\"", "node = \"roof\"", "node = \"roof\"",
       "node: there is no node \"roof\"; allowed: front, rear"},
      {"line = 1", "line = 0",
       "name = \"front_right\"\nmass_kg = 34\nmass_sigma_kg = 0\nrotating_mass_kg = 26\nrolling_radius_m = "
       "0.30\n"
       "weight_radius_m = 0.19\nnode = \"front\"\nline",
       "line: line 0 of node front has a wheel already"},
      {"line = 1", "line = 2", "line = 2", "line: is 2; allowed: an integer 0 .. 1"},
      {"id = 2", "id = 1", "name = \"rear\"\nid", "id: 1 stands twice"},
      {"name = \"rear\"\nid", "name = \"front\"\nid", "range_m_s2 = 50\n\n[[node]]\nname",
       "name: \"front\" stands twice"},
      {"name = \"rear\"\nid", "name = \"Rear axle\"\nid", "Rear axle",
       "name: allowed: lower-case letters, digits and _"},
      {"mount = \"front_left\"", "mount = \"roof\"", "mount = \"roof\"",
       "mount: is 'roof'; allowed: front_left, front_right, rear_left, rear_right, body"},
      {"direction = [1, 0, 0]", "direction = [0, 0, 0]", "[0, 0, 0]",
       "direction: is no direction; allowed: a unit vector"},
      {"direction = [1, 0, 0]", "direction = [1, 0]", "[1, 0]", "direction: allowed: 3 numbers in [ ]"},
      {"name = \"fl_carrier_y\"", "name = \"fl_carrier_x\"", "rate_hz = 2000\n[[node.channel]]",
       "name \"fl_carrier_x\" stands twice"},
      {"x_m = -1.45", "x_m = 1.25", "[model.rear]",
       "rear: x_m of the rear axle must be less than the front's"},
  };
  for (const Case& c : cases) test::expect_refusal(changed(c.from, c.to), 0, c.line, c.says);
}

TEST(VehicleConfig, RefusesMoreChannelsThanAConverterHas) {
  const std::string thirteenth =
      "[[node.channel]]\nname = \"one_more\"\nmount = \"body\"\nposition_m = [0, 0, 0]\nrange_m_s2 = 50\n";
  EXPECT_NE(refusal(demo() + thirteenth).find("has 13 channels; allowed: at most 12"), std::string::npos);
}

// A name is printed in a line of its own: a new line in it would be another line, "complete" for one.
TEST(VehicleConfig, RefusesTextsWithCharactersThatNobodySees) {
  for (const auto& [written, shown] :
       {std::pair{"car\\ncomplete", "\\x0A"}, std::pair{"a\\tb", "\\x09"}, std::pair{"x\\uFE0F", "\\uFE0F"},
        std::pair{"x\\U000E0041", "\\U000E0041"}}) {
    const std::string error = refusal(changed("demonstration car\"", std::string(written) + "\""));
    EXPECT_NE(error.find("has the hidden character " + std::string(shown)), std::string::npos) << error;
  }
}

TEST(VehicleConfig, RefusesAFileThatIsNoToml) {
  const auto error = refusal("name = \"x\"\n[model\n");
  EXPECT_EQ(error.rfind("car.toml:2: not TOML: ", 0), 0U) << error;
}

TEST(VehicleConfig, RefusesWhatTheTomlLibraryTakesForItsOwnMistake) {
  for (const char* text : {"[,]", "x = 1\n[[#", "\u00e9 = 1", "x = 1 \u0605"}) {
    const std::string error = refusal(text);
    EXPECT_EQ(error.rfind("car.toml:", 0), 0U) << error;
    EXPECT_NE(error.find(": not TOML: "), std::string::npos) << error;
  }
}

TEST(VehicleConfig, RefusesAMeasuredRoadThatNoChannelMeasures) {
  const auto error = refusal(demo() + "\n[road]\nmeasured = true\n");
  EXPECT_NE(error.find("measured: no channel of role road has mount front_left; allowed: false"),
            std::string::npos)
      << error;
}

TEST(VehicleConfig, SaysOfAFileThatCannotBeReadWhichAndWhy) {
  const auto says = [](const std::string& path) -> std::string {
    try {
      VehicleConfig::read_file(path);
    } catch (const std::system_error& error) {
      return error.what();
    }
    return "read";
  };
  EXPECT_EQ(says("/nowhere/car.toml"), "read /nowhere/car.toml: No such file or directory");
  EXPECT_EQ(says("/tmp"), "read /tmp: Is a directory");
}

}  // namespace
}  // namespace roadbalance
