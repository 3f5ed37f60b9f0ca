#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"

namespace roadbalance {

/// The part of the car that a channel sits on, and so the motion that predicts it.
enum class TwinPart : int { kBody = 0, kFront = 1, kRear = 2 };
inline constexpr int kTwinParts = 3;

/// The channels that the model of seven coordinates has: vertical accelerometers on the body and the wheels'
/// carriers.  It has no prediction for others (fore-and-aft, sideways, not an acceleration).
struct TwinChannels {
  struct One {
    int node;     ///< index into VehicleConfig::node
    int channel;  ///< index into NodeConfig::channel
    TwinPart part;
  };
  std::vector<One> channel;
  Eigen::MatrixXd from_coordinates;  ///< [channels x 7] what each reads of z''
  Eigen::MatrixXd wheels_from;       ///< [4 x channels] the wheels' z'' from what the channels read

  /// @throws ConfigError naming the coordinate that no sensor sees, or if the car has a description of its
  /// own
  static TwinChannels of(const VehicleConfig& vehicle);
};

}  // namespace roadbalance
