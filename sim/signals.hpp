#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/frontend/front_end.hpp"
#include "sim/drawn_car.hpp"
#include "sim/drive.hpp"

namespace roadbalance::sim {

/// What the car's own controllers say on its buses: the signals that vehicle.toml wants of a node's CAN
/// interfaces, all of them every 10 ms of bus time, from 0 on.
///
/// Wheel speed is rotation times the rolling radius of vehicle.toml, as a brake controller knows it; a pulse
/// counter counts the teeth of an even ring and wraps at 256; the car drives straight on.  A signal of
/// quantity "other" is never sent: nobody knows what it means.
class Signals {
 public:
  static constexpr std::int64_t kPeriod_ns = 10'000'000;

  Signals(const VehicleConfig& vehicle, const NodeConfig& node, const DrawnCar& car);

  /// How many there are at each instant.
  std::size_t size() const { return source_.size(); }
  /// The k-th at an instant; k < size().
  SignalSample at(std::size_t k, NodeTime time, const Motion& motion) const;

 private:
  struct Source {
    std::uint16_t signal;
    SignalQuantity quantity;
    double told_radius_m, true_radius_m;  ///< of its wheel
    double pulses, angle_rad;             ///< of its ring: teeth, and encoder angle at position 0
  };
  std::vector<Source> source_;
};

}  // namespace roadbalance::sim
