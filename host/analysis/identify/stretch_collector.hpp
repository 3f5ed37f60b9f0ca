#pragma once

#include <functional>
#include <optional>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/decimate.hpp"
#include "host/analysis/identify/stretch.hpp"

namespace roadbalance {

/// Cuts a recorded drive into stretches of steady driving for the estimators.
///
/// It is looked at second by second: a stretch ends before a hole, before a second whose mean speed differs
/// from the stretch's by 2 % or more, in which a wheel that has an encoder shows no angle, or that is slower
/// than the vehicle's least speed, and after a minute.  Shorter ones than section_s are dropped.
class StretchCollector {
 public:
  using Emit = std::function<void(const Stretch&)>;

  StretchCollector(const VehicleConfig& vehicle, Emit emit);

  void consume(const IdentificationSample& sample);
  /// No sample comes any more.
  void finish();

 private:
  void take_second();
  void close(Eigen::Index samples);

  const VehicleConfig vehicle_;
  double rate_hz_;
  Eigen::Index second_, least_;
  Eigen::Index settling_ = 0;  ///< samples still to skip
  SignalMatrix signals_;
  RoadMatrix road_m_;
  bool road_measured_ = false;
  Eigen::Index filled_ = 0;
  Emit emit_;
};

}  // namespace roadbalance
