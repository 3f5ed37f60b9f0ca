#pragma once

#include <Eigen/Core>

#include "host/analysis/identify/signals.hpp"

namespace roadbalance {

/// Consecutive samples of driving at one steady speed, filters settled: what estimators work on.
struct Stretch {
  double rate_hz = 0.0;
  double speed_m_s = 0.0;
  /// Mean rotation rate of each wheel, rad/s; 0: it has no reference here.
  Eigen::Vector4d omega = Eigen::Vector4d::Zero();
  SignalMatrix signals;
  /// [channel x samples] m/s^2 of each vertical channel (SensorMap), of drives that are computed; recorded
  /// ones have none.
  Eigen::MatrixXd readings{};
  /// Having passed the filters of `signals`; no columns: the road was not measured.
  RoadMatrix road_m;

  double seconds() const { return static_cast<double>(signals.cols()) / rate_hz; }
};

}  // namespace roadbalance
