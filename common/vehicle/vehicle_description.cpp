#include "common/vehicle/vehicle_description.hpp"

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <filesystem>

#include "common/multibody/shipped.hpp"
#include "common/vehicle/linear_model.hpp"

namespace roadbalance {
namespace {

std::array<Formula, 3> formulas(const Eigen::Vector3d& numbers) {
  std::array<Formula, 3> three;
  for (std::size_t i = 0; i < 3; ++i) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", numbers(static_cast<Eigen::Index>(i)));
    three[i] = Formula(text);
  }
  return three;
}

void put_sensors(const VehicleConfig& vehicle, Description& description) {
  description.sensor.clear();
  for (const NodeConfig& node : vehicle.node)
    for (const ChannelConfig& channel : node.channel) {
      const auto body = std::ranges::find(description.body, channel.mount, &BodyDescription::name);
      if (channel.role != ChannelRole::kAcceleration || body == description.body.end()) continue;
      // A wheel's own place has no part in what it reads: wheels do not turn but about their axle.
      const Eigen::Vector3d place = channel.mount == "body" ? channel.position_m : Eigen::Vector3d::Zero();
      const auto point = static_cast<int>(description.point.size());
      description.point.push_back(
          {channel.name, static_cast<int>(body - description.body.begin()), formulas(place)});
      description.sensor.push_back({channel.name, point, formulas(channel.direction)});
    }
}

}  // namespace

Description description_of(const VehicleConfig& vehicle) {
  if (!vehicle.model.description.empty())
    return Description::read_file(
        (std::filesystem::path(vehicle.folder) / vehicle.model.description).string());
  Description description = shipped_description("seven_dof");
  description.name = vehicle.name;
  const ParameterVector parameters = nominal_parameters(vehicle);
  const Geometry geometry = geometry_of(vehicle.model);
  assert(description.parameter.size() > kParameters && description.geometry.size() == 2 * kWheels);
  for (std::size_t k = 0; k < kParameters; ++k)
    description.parameter[k].value = parameters(static_cast<Eigen::Index>(k));
  for (std::size_t w = 0; w < kWheels; ++w) {
    description.geometry[w].value = geometry.x_m[w];
    description.geometry[kWheels + w].value = geometry.y_m[w];
  }
  put_sensors(vehicle, description);
  return description;
}

}  // namespace roadbalance
