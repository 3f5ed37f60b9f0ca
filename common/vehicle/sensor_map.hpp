#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"

namespace roadbalance {

/// Least-squares map from vertical sensors of all nodes to the seven accelerations z''.
///
/// A sensor on the body at (x, y) with direction (0, 0, +-1) reads +-(heave'' + y roll'' - x pitch''), one on
/// a wheel carrier the wheel's z''.  Sensors whose direction is not vertical (|d_z| < 0.999) take no part.
struct SensorMap {
  struct Input {
    int node;     ///< index into VehicleConfig::node
    int channel;  ///< index into NodeConfig::channel
  };
  std::vector<Input> input;        ///< columns of `pseudo_inverse`
  Eigen::MatrixXd readings;        ///< [inputs x 7] each input's reading per unit of z''
  Eigen::MatrixXd pseudo_inverse;  ///< [7 x inputs]

  /// @throws ConfigError naming the coordinate that no sensor sees, or if the car has a description of its
  /// own
  static SensorMap from(const VehicleConfig& vehicle);
  /// By the sensors on the body alone: heave'', roll'' and pitch''; the wheels' rows are 0.
  /// @throws as from()
  static SensorMap of_body(const VehicleConfig& vehicle);
};

}  // namespace roadbalance
