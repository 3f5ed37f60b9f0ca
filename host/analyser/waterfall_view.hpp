#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "common/bus/display.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/block.hpp"
#include "common/types/clocks.hpp"
#include "common/types/exchange.hpp"
#include "host/analysis/orders/rotor_orders.hpp"

namespace roadbalance {

/// Order spectra by speed that viewers ask for, and no others: each wheel and channel once, begun when
/// it is first asked for and forgotten kForgotten after it was last.
class WaterfallView {
 public:
  static constexpr std::chrono::seconds kForgotten{3};
  static constexpr std::size_t kMostWaterfalls = 8;
  static constexpr double kLeastRotation_hz = 4.0;  ///< 27 km/h

  explicit WaterfallView(VehicleConfig vehicle) : vehicle_(std::move(vehicle)) {}

  void take(const View& view, WallTime now);
  /// Blocks of each node in sequence, and fits of their clocks between them.
  void consume(const SealedBlock& block);
  void consume(const ClockFit& fit);

  /// All classes of speed of all that is wanted, as they stand; one row without lines of what there is
  /// nothing to send.
  std::vector<WaterfallRow> rows(WallTime now);

 private:
  struct Wanted {
    WallTime heard;
    OrderState state = OrderState::kComputed;   ///< else why nothing is computed
    std::unique_ptr<RotorOrders> orders{};  ///< nullptr: for that reason
    std::int64_t time_ns = 0;               ///< of the newest block
  };
  Wanted begin(const WheelChannel& of);
  void forget(WallTime now);

  VehicleConfig vehicle_;
  std::map<WheelChannel, Wanted> wanted_;
  std::map<std::int32_t, ClockFit> newest_fit_;  ///< by node
};

}  // namespace roadbalance
