#include "common/vehicle/sensor_map.hpp"

#include <cmath>
#include <string>

#include <Eigen/LU>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

/// The map to the first `coordinates` of the seven.
SensorMap map_to(int coordinates, const VehicleConfig& vehicle) {
  if (!vehicle.model.description.empty())
    throw ConfigError(
        "vehicle.toml: kind of [model] is \"description\"; the car is identified as \"seven_dof\" only");
  SensorMap map;
  std::vector<Vector7> rows;
  for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
    for (std::size_t c = 0; c < vehicle.node[n].channel.size(); ++c) {
      const ChannelConfig& channel = vehicle.node[n].channel[c];
      const double up = channel.direction.z();
      if (channel.role != ChannelRole::kAcceleration || std::abs(up) < 0.999) continue;
      Vector7 row = Vector7::Zero();
      if (channel.mount == "body") row.head<3>() << 1.0, channel.position_m.y(), -channel.position_m.x();
      for (std::size_t w = 0; w < kWheels; ++w)
        if (channel.mount == kWheelNames[w]) row(kBodyCoordinates + static_cast<int>(w)) = 1.0;
      if (row.head(coordinates).isZero()) continue;
      rows.push_back(up * row);
      map.input.push_back({static_cast<int>(n), static_cast<int>(c)});
    }
  }
  Eigen::MatrixXd sensors(static_cast<Eigen::Index>(rows.size()), coordinates);
  for (std::size_t i = 0; i < rows.size(); ++i)
    sensors.row(static_cast<Eigen::Index>(i)) = rows[i].head(coordinates);
  static constexpr std::array<const char*, kCoordinates> kNames{
      "heave", "roll", "pitch", "front_left", "front_right", "rear_left", "rear_right"};
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(sensors.transpose() * sensors);
  if (lu.rank() < coordinates) {
    const Eigen::MatrixXd unseen = lu.kernel();
    std::string names;
    for (int i = 0; i < coordinates; ++i)
      if (unseen.row(i).cwiseAbs().maxCoeff() > 1e-6)
        names += (names.empty() ? "" : ", ") + std::string(kNames[static_cast<std::size_t>(i)]);
    throw ConfigError("vehicle.toml: the vertical sensors of all nodes do not determine: " + names);
  }
  map.readings.setZero(sensors.rows(), kCoordinates);
  map.readings.leftCols(coordinates) = sensors;
  map.pseudo_inverse.setZero(kCoordinates, sensors.rows());
  map.pseudo_inverse.topRows(coordinates) = (sensors.transpose() * sensors).inverse() * sensors.transpose();
  return map;
}

}  // namespace

SensorMap SensorMap::from(const VehicleConfig& vehicle) {
  return map_to(kCoordinates, vehicle);
}

SensorMap SensorMap::of_body(const VehicleConfig& vehicle) {
  return map_to(kBodyCoordinates, vehicle);
}

}  // namespace roadbalance
