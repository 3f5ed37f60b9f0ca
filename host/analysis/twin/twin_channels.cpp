#include "host/analysis/twin/twin_channels.hpp"

#include <Eigen/LU>

#include "common/vehicle/sensor_map.hpp"

namespace roadbalance {
namespace {

TwinPart part_of(const ChannelConfig& channel) {
  if (channel.mount == "body") return TwinPart::kBody;
  const bool front = channel.mount == kWheelNames[0] || channel.mount == kWheelNames[1];
  return front ? TwinPart::kFront : TwinPart::kRear;
}

}  // namespace

TwinChannels TwinChannels::of(const VehicleConfig& vehicle) {
  const SensorMap map = SensorMap::from(vehicle);
  TwinChannels channels;
  for (const SensorMap::Input& input : map.input) {
    const NodeConfig& node = vehicle.node[static_cast<std::size_t>(input.node)];
    channels.channel.push_back(
        {input.node, input.channel, part_of(node.channel[static_cast<std::size_t>(input.channel)])});
  }
  // The pseudo-inverse of a pseudo-inverse of full rank is the matrix itself.
  const Eigen::MatrixXd& back = map.pseudo_inverse;
  channels.from_coordinates = back.transpose() * (back * back.transpose()).inverse();
  channels.wheels_from = back.bottomRows<kWheels>();
  return channels;
}

}  // namespace roadbalance
