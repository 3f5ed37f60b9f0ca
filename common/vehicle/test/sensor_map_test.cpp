#include <random>

#include <gtest/gtest.h>

#include "common/config/section.hpp"
#include "common/test/source.hpp"
#include "common/vehicle/linear_model.hpp"
#include "common/vehicle/sensor_map.hpp"

namespace roadbalance {
namespace {

VehicleConfig car(const std::string& file = "sim/demo/vehicle.toml") {
  return VehicleConfig::parse(test::read_source(file), file);
}

/// A sensor reads the height of its place in the coordinates, times its direction.
double reading(const ChannelConfig& channel, const Vector7& z) {
  double up = 0.0;
  if (channel.mount == "body") up = z(0) + channel.position_m.y() * z(1) - channel.position_m.x() * z(2);
  for (std::size_t w = 0; w < kWheels; ++w)
    if (channel.mount == kWheelNames[w]) up = z(3 + static_cast<int>(w));
  return channel.direction.z() * up;
}

void expect_exact(const VehicleConfig& vehicle, std::size_t inputs) {
  const SensorMap map = SensorMap::from(vehicle);
  ASSERT_EQ(map.input.size(), inputs);
  ASSERT_EQ(map.pseudo_inverse.rows(), kCoordinates);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int repeat = 0; repeat < 10; ++repeat) {
    Vector7 z;
    for (double& value : z) value = normal(random);
    Eigen::VectorXd measured(static_cast<Eigen::Index>(inputs));
    for (std::size_t i = 0; i < inputs; ++i)
      measured(static_cast<Eigen::Index>(i)) =
          reading(vehicle.node[static_cast<std::size_t>(map.input[i].node)]
                      .channel[static_cast<std::size_t>(map.input[i].channel)],
                  z);
    EXPECT_LT((map.pseudo_inverse * measured - z).norm(), 1e-12);
  }
}

ChannelConfig* find(VehicleConfig& vehicle, const std::string& name) {
  for (auto& node : vehicle.node)
    for (auto& channel : node.channel)
      if (channel.name == name) return &channel;
  return nullptr;
}

std::string refusal(const VehicleConfig& vehicle) {
  try {
    SensorMap::from(vehicle);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SensorMap, RecoversTheAccelerationsExactly) {
  expect_exact(car(), 8);
  expect_exact(car("sim/demo/vehicle-3-nodes.toml"), 12);
}

TEST(SensorMap, MakesDoWithThreeSensorsOnTheBody) {
  auto vehicle = car();
  find(vehicle, "rr_strut_z")->role = ChannelRole::kUnused;
  expect_exact(vehicle, 7);
}

TEST(SensorMap, TurnsSensorsThatHangUpsideDown) {
  auto vehicle = car();
  find(vehicle, "fl_carrier_z")->direction = {0, 0, -1};
  find(vehicle, "rl_strut_z")->direction = {0, 0, -1};
  expect_exact(vehicle, 8);
}

TEST(SensorMap, LeavesOutSensorsThatDoNotLookUp) {
  auto vehicle = car();
  find(vehicle, "rr_strut_z")->direction = {0, 0.6, 0.8};
  expect_exact(vehicle, 7);
}

TEST(SensorMap, NamesTheCoordinateThatNobodySees) {
  auto vehicle = car();
  find(vehicle, "rl_carrier_z")->role = ChannelRole::kUnused;
  EXPECT_EQ(refusal(vehicle), "vehicle.toml: the vertical sensors of all nodes do not determine: rear_left");
  vehicle = car();
  for (auto& node : vehicle.node)
    for (auto& channel : node.channel)
      if (channel.mount == "body") channel.position_m.y() = 0.0;  // all on the centre line: no roll
  EXPECT_EQ(refusal(vehicle), "vehicle.toml: the vertical sensors of all nodes do not determine: roll");
}

TEST(SensorMap, MapsTheBodyWhereTheCarriersHaveNoSensors) {
  VehicleConfig vehicle = car();
  for (const char* wheel : {"fl", "fr", "rl", "rr"})
    find(vehicle, std::string(wheel) + "_carrier_z")->role = ChannelRole::kUnused;
  EXPECT_NE(refusal(vehicle).find("rear_left"), std::string::npos) << refusal(vehicle);
  const SensorMap map = SensorMap::of_body(vehicle);
  ASSERT_EQ(map.input.size(), 4U);
  Vector7 z;
  z << 0.3, -0.2, 0.7, 1.0, 2.0, 3.0, 4.0;
  Eigen::Vector4d measured;
  for (std::size_t i = 0; i < 4; ++i)
    measured(static_cast<Eigen::Index>(i)) =
        reading(vehicle.node[static_cast<std::size_t>(map.input[i].node)]
                    .channel[static_cast<std::size_t>(map.input[i].channel)],
                z);
  z.tail<kWheels>().setZero();
  EXPECT_LT((map.pseudo_inverse * measured - z).norm(), 1e-12);
}

}  // namespace
}  // namespace roadbalance
