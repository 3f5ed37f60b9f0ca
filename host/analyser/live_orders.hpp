#pragma once

#include <memory>
#include <vector>

#include "common/bus/order_report.hpp"
#include "common/config/vehicle_config.hpp"
#include "host/analysis/orders/rotor_orders.hpp"

namespace roadbalance {

/// First and second order of every wheel with an encoder in the accelerations of every node, from the growing
/// record: the vectors that `rb orders` finds in the finished one, but for what turned slower than
/// kLeastRotation_hz.  Where the teeth of a wheel are counted on the bus, its vectors are those of the angle
/// as it was known live, and the 95 % of a phase leave out the part of that angle's error that is the same
/// all through the drive; `rb orders` computes both again from all that was recorded.
///
/// A node's channels are analysed with each node that reads wheels for itself, so that a node that stays away
/// costs its own channels only.  The price: every block is decoded and aligned once for every such pair it
/// belongs to, and while a node stays away every pair with it holds a minute of the other's scans, 8 MB at
/// 2 kHz.
class LiveOrders {
 public:
  static constexpr double kLeastRotation_hz = 6.0;  ///< 40 km/h
  static constexpr double kHighest_hz = 80.0;       ///< the second order at 270 km/h

  explicit LiveOrders(const VehicleConfig& vehicle);

  /// Blocks of each node in sequence, with the fits of its clock between them.
  void consume(const SealedBlock& block);
  void consume(const ClockFit& fit);

  /// Over the drive so far; one for each wheel and node of which scans came.
  std::vector<OrderReport> reports() const;

 private:
  struct One {
    int wheel;
    std::unique_ptr<RotorOrders> orders;
    std::int64_t time_ns = 0;
  };
  void add(One one);

  std::vector<One> all_;
  std::vector<RotorOrders*> consuming_;  ///< those of all_ that share with the others
};

}  // namespace roadbalance
