#include "common/vehicle/linear_model.hpp"

#include <Eigen/LU>
#include <cmath>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

/// Row i: strut stretch of wheel i, corner of the body minus wheel.
Eigen::Matrix<double, kWheels, kCoordinates> stretch_rows(const Geometry& geometry) {
  Eigen::Matrix<double, kWheels, kCoordinates> rows = decltype(rows)::Zero();
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    rows.row(i).head<3>() << 1.0, geometry.y_m[w], -geometry.x_m[w];
    rows(i, kBodyCoordinates + i) = -1.0;
  }
  return rows;
}

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
  map.pseudo_inverse.setZero(kCoordinates, sensors.rows());
  map.pseudo_inverse.topRows(coordinates) = (sensors.transpose() * sensors).inverse() * sensors.transpose();
  return map;
}

}  // namespace

Geometry geometry_of(const ModelConfig& model) {
  Geometry geometry{};
  for (std::size_t i = 0; i < kWheels; ++i) {
    const AxleConfig& axle = model.axle[i / 2];
    geometry.x_m[i] = axle.x_m;
    geometry.y_m[i] = i % 2 == 0 ? axle.half_track_m : -axle.half_track_m;
  }
  return geometry;
}

ParameterVector nominal_parameters(const VehicleConfig& vehicle) {
  ParameterVector p;
  p(kBodyMass) = vehicle.model.body_mass_kg;
  p(kRollInertia) = vehicle.model.roll_inertia_kg_m2;
  p(kPitchInertia) = vehicle.model.pitch_inertia_kg_m2;
  for (int i = 0; i < kWheels; ++i) {
    const AxleConfig& axle = vehicle.model.axle[static_cast<std::size_t>(i / 2)];
    p(kWheelMass + i) = vehicle.wheel[static_cast<std::size_t>(i)].mass_kg;
    p(kSpring + i) = axle.spring_n_m;
    p(kDamper + i) = axle.damper_n_s_m;
    p(kTyre + i) = axle.tyre_n_m;
    p(kTyreDamper + i) = axle.tyre_damper_n_s_m;
  }
  for (int a = 0; a < kAxles; ++a)
    p(kStabiliser + a) = vehicle.model.axle[static_cast<std::size_t>(a)].stabiliser_n_m;
  return p;
}

LinearModel linear_model(const Geometry& geometry, const ParameterVector& p) {
  const auto B = stretch_rows(geometry);
  LinearModel m;
  m.M = p.head<kCoordinates>().asDiagonal();
  m.P = B.transpose() * p.segment<kWheels>(kDamper).asDiagonal() * B;
  m.Q = B.transpose() * p.segment<kWheels>(kSpring).asDiagonal() * B;
  for (int a = 0; a < kAxles; ++a) {
    const auto twist = (B.row(2 * a) - B.row(2 * a + 1)).eval();
    m.Q += p(kStabiliser + a) * twist.transpose() * twist;
  }
  m.Q.diagonal().tail<kWheels>() += p.segment<kWheels>(kTyre);
  m.P.diagonal().tail<kWheels>() += p.segment<kWheels>(kTyreDamper);
  m.S.setZero();
  m.S.bottomRows<kWheels>() = p.segment<kWheels>(kTyre).asDiagonal();
  m.Sd.setZero();
  m.Sd.bottomRows<kWheels>() = p.segment<kWheels>(kTyreDamper).asDiagonal();
  m.W.setZero();
  m.W.bottomRows<kWheels>().setIdentity();
  return m;
}

SensorMap SensorMap::from(const VehicleConfig& vehicle) {
  return map_to(kCoordinates, vehicle);
}

SensorMap SensorMap::of_body(const VehicleConfig& vehicle) {
  return map_to(kBodyCoordinates, vehicle);
}

}  // namespace roadbalance
