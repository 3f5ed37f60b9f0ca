#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/types/scan.hpp"
#include "sim/drawn_car.hpp"
#include "sim/drive.hpp"
#include "sim/random.hpp"

namespace roadbalance::sim {

/// The messages of the car's own controllers on its buses: the signals that vehicle.toml asks for on a node's
/// CAN interfaces, all of them every 10 ms of bus time, from 0 on.
///
/// Wheel speed is rotation times the rolling radius of vehicle.toml, as a brake controller has it; the car
/// drives straight on.  A pulse counter counts the teeth of an even wheel, wraps and steps by its
/// [node.can.signal.counter], and is as old as given there with its jitter; the mean is right to the full,
/// and the code that would mean "no count" is sent as any other.  A signal of quantity "other" is never sent:
/// its meaning is unknown.
class Signals {
 public:
  static constexpr std::int64_t kPeriod_ns = 10'000'000;

  Signals(const VehicleConfig& vehicle, const NodeConfig& node, const DrawnCar& car, std::uint64_t seed);

  /// How many there are at each instant.
  std::size_t size() const { return source_.size(); }
  /// The k-th at the instant that is so many periods after 0; k < size().
  SignalSample at(std::size_t k, std::int64_t instant, const Drive& drive) const;

 private:
  struct Source {
    std::uint16_t signal;
    SignalQuantity quantity;
    double nominal_radius_m, true_radius_m;  ///< of its wheel
    double pulses, angle_rad;                ///< of its ring: teeth, and encoder angle at position 0
    CounterForm counter;
    CounterLatency latency;
    RandomSequence age;  ///< of a counter's messages
  };
  double teeth_passed(const Source& source, std::int64_t instant, const Drive& drive) const;
  std::vector<Source> source_;
};

}  // namespace roadbalance::sim
