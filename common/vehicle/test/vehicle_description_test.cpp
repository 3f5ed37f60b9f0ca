#include "common/vehicle/vehicle_description.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "common/config/section.hpp"
#include "common/multibody/affine_model.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "common/vehicle/linear_model.hpp"
#include "common/vehicle/sensor_map.hpp"

namespace roadbalance {
namespace {

std::string demo() {
  return test::read_source("sim/demo/vehicle.toml");
}

/// Names of the parameters of vehicle.toml, written out once more.
std::vector<std::string> names() {
  std::vector<std::string> all{"body_mass", "roll_inertia", "pitch_inertia"};
  const auto of_wheels = [&all](const std::string& what) {
    for (const char* wheel : kWheelNames) all.push_back(what + "_" + wheel);
  };
  for (const char* what : {"wheel_mass", "spring", "damper"}) of_wheels(what);
  all.insert(all.end(), {"stabiliser_front", "stabiliser_rear"});
  for (const char* what : {"tyre", "tyre_damper"}) of_wheels(what);
  return all;
}

TEST(VehicleDescription, ParametersStandInTheOrderOfTheModel) {
  const Description description = description_of(VehicleConfig::parse(demo(), "vehicle.toml"));
  ASSERT_EQ(names().size(), static_cast<std::size_t>(kParameters));
  for (std::size_t k = 0; k < kParameters; ++k) EXPECT_EQ(description.parameter[k].name, names()[k]);
  for (std::size_t w = 0; w < kWheels; ++w) {
    EXPECT_EQ(description.coordinate[static_cast<std::size_t>(kBodyCoordinates) + w].name, kWheelNames[w]);
    EXPECT_EQ(description.tyre[w].name, kWheelNames[w]);
    EXPECT_EQ(description.geometry[w].name, std::string("x_") + kWheelNames[w]);
    EXPECT_EQ(description.geometry[kWheels + w].name, std::string("y_") + kWheelNames[w]);
  }
}

TEST(VehicleDescription, GivesTheMatricesThatIdentificationUses) {
  VehicleConfig vehicle = VehicleConfig::parse(demo(), "vehicle.toml");
  vehicle.model.body_mass_kg = 1234;
  vehicle.model.axle[0].x_m = 1.11;
  vehicle.model.axle[1].half_track_m = 0.66;
  vehicle.model.axle[1].tyre_damper_n_s_m = 99;
  vehicle.wheel[2].mass_kg = 41;
  const AffineModel model = affine_model(derive(description_of(vehicle)));
  const ModelMatrices m = model.at(model.nominal);
  const LinearModel used = linear_model(geometry_of(vehicle.model), nominal_parameters(vehicle));
  EXPECT_LT((m.M - used.M).norm(), 1e-9);
  EXPECT_LT((m.P - used.P).norm(), 1e-9);
  EXPECT_LT((m.Q - used.Q).norm(), 1e-9);
  EXPECT_LT((m.S - used.S).norm(), 1e-9);
  EXPECT_LT((m.Sd - used.Sd).norm(), 1e-9);
  EXPECT_LT((model.up - used.W).norm(), 1e-12);
}

TEST(VehicleDescription, SensorsReadWhatTheMapOfSensorsUndoes) {
  const VehicleConfig vehicle = VehicleConfig::parse(demo(), "vehicle.toml");
  const AffineModel model = affine_model(derive(description_of(vehicle)));
  const SensorMap map = SensorMap::from(vehicle);
  ASSERT_EQ(model.sensor.size(), 24U);
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(map.input.size()), kCoordinates);
  for (std::size_t i = 0; i < map.input.size(); ++i) {
    const auto& input = map.input[i];
    const std::string& name = vehicle.node[static_cast<std::size_t>(input.node)]
                                  .channel[static_cast<std::size_t>(input.channel)]
                                  .name;
    const auto place = std::ranges::find(model.sensor, name) - model.sensor.begin();
    ASSERT_LT(place, 24);
    rows.row(static_cast<Eigen::Index>(i)) = model.acceleration.row(place);
    EXPECT_TRUE(model.tilt.row(place).isZero()) << name;  // looks up: tilting is of second order
  }
  EXPECT_LT((map.pseudo_inverse * rows - Eigen::MatrixXd::Identity(kCoordinates, kCoordinates)).norm(),
            1e-12);
}

TEST(VehicleDescription, ASensorThatLooksForwardFeelsThePitch) {
  const AffineModel model =
      affine_model(derive(description_of(VehicleConfig::parse(demo(), "vehicle.toml"))));
  const auto place = std::ranges::find(model.sensor, "fl_strut_x") - model.sensor.begin();
  Eigen::RowVectorXd acceleration = Eigen::RowVectorXd::Zero(kCoordinates), tilt = acceleration;
  acceleration(2) = 0.4;  // its height over the centre of mass
  tilt(2) = -9.81;        // nose down: gravity pulls it forward, so it reads as if braking
  EXPECT_LT((model.acceleration.row(place) - acceleration).norm(), 1e-12);
  EXPECT_LT((model.tilt.row(place) - tilt).norm(), 1e-12);
}

TEST(VehicleDescription, TakesAFileOfItsOwnFromTheVehiclesFolder) {
  const test::TemporaryDirectory folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder.path() / name) << text;
  };
  std::string text = demo();
  const auto begin = text.find("kind = \"seven_dof\""), end = text.find("[filter]");
  text.replace(begin, end - begin, "kind = \"description\"\nfile = \"half.toml\"\n");
  write("vehicle.toml", text);
  write("half.toml", test::read_source("common/multibody/descriptions/half_car.toml"));
  const VehicleConfig vehicle = VehicleConfig::read_file((folder.path() / "vehicle.toml").string());
  EXPECT_EQ(description_of(vehicle).name, "half car");
  try {
    SensorMap::from(vehicle);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("identified as \"seven_dof\" only"), std::string::npos);
  }
}

}  // namespace
}  // namespace roadbalance
