#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/frontend/front_end.hpp"
#include "sim/drawn_car.hpp"
#include "sim/drive.hpp"

namespace roadbalance::sim {

/// The references of a node with loop-back: a frequency generator that knows each wheel's angle, D/A
/// converters of 16 bits, ten codes a scan, the anti-aliasing filter of vehicle.toml, and A/D converters.
///
/// A code stands for the middle of the time that it is held: it enters the filter as if there were straight
/// lines between the codes.
class LoopBack {
 public:
  LoopBack(const VehicleConfig& vehicle, const NodeConfig& node, const DrawnCar& car, double rate_hz);

  /// Goes on to scan number `scan`, each one in turn, and fills its references; of a node that computes them
  /// itself there is nothing to do.
  void convert(const Drive& drive, std::int64_t scan, Scan& out);

 private:
  static constexpr int kCodesPerScan = 10;
  static constexpr double kAmplitude = 0.9;
  struct Wheel {
    std::size_t line;
    double radius_m, initial_rad;
  };

  bool wanted_;
  double rate_hz_;
  std::vector<Wheel> wheel_;
  StateFilter filter_;  ///< rows sin, cos of line 0, of line 1
};

}  // namespace roadbalance::sim
