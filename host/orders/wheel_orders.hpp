#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/link/block.hpp"
#include "host/orders/angle_resampler.hpp"
#include "host/orders/order_vectors.hpp"
#include "host/orders/order_waterfall.hpp"

namespace roadbalance {

/// Orders of one wheel in channels of the node that reads its encoder: their samples and the wheel's angle
/// are of the same scans, so no clock comes between.
///
///     scan blocks ─▶ angle, channels ─▶ AngleResampler ─┬▶ blocks of 32 turns ─▶ OrderWaterfall
///                                                       └▶ blocks of 8 turns ──▶ OrderVectors
///
/// Where the angle is not known, or a turn had not exactly its teeth, or scans are missing, or the wheel
/// turns slower than kLeastRotation_hz, nothing is used; an overload takes its channel out of the blocks it
/// touches.  Memory does not grow with the drive.
class WheelOrders {
 public:
  static constexpr int kRowsPerTurn = 64;
  static constexpr int kSpectrumTurns = 32;
  static constexpr int kVectorTurns = 8;
  static constexpr double kLeastRotation_hz = 2.0;  ///< 13 km/h

  /// Seconds of the drive; those that are not used, by their reason.
  struct Seconds {
    double recorded = 0.0;
    double no_angle = 0.0;   ///< the node did not know the wheel's angle
    double uncertain = 0.0;  ///< known, but a turn did not have exactly its teeth
    double slow = 0.0;
  };

  /// @param wheel    of that vehicle, with an encoder
  /// @param channel  places in the channels of the node that reads it; at least one
  /// @param order    of the vectors
  /// @throws std::invalid_argument if vectors of these orders cannot be had
  WheelOrders(const VehicleConfig& vehicle, const WheelConfig& wheel, std::vector<std::size_t> channel,
              std::vector<double> order);
  WheelOrders(const WheelOrders&) = delete;
  WheelOrders& operator=(const WheelOrders&) = delete;

  /// Blocks of all nodes, those of each in sequence.
  void consume(const SealedBlock& sealed);

  const WheelConfig& wheel() const { return wheel_; }
  const NodeConfig& node() const { return node_; }
  const std::vector<std::size_t>& channel() const { return channel_; }
  const std::vector<double>& order() const { return order_; }
  double rolling_radius_m() const { return wheel_.rolling_radius_m; }
  Seconds seconds() const;
  std::int64_t gaps() const { return gaps_; }
  /// Channels are counted as in channel().
  const OrderWaterfall& waterfall() const { return waterfall_; }
  const OrderVectors& vectors() const { return vectors_; }

 private:
  void add_rows(const SealedBlock& sealed);

  WheelConfig wheel_;
  NodeConfig node_;
  std::vector<std::size_t> channel_;
  std::vector<double> order_;
  OrderWaterfall waterfall_;
  OrderVectors vectors_;
  TurnBlocks spectrum_blocks_, vector_blocks_;
  AngleResampler resampler_;
  Eigen::VectorXd values_;
  std::int64_t epoch_ = 0, next_scan_ = -1;
  std::int64_t scans_ = 0, no_angle_ = 0, uncertain_ = 0, gaps_ = 0;
};

}  // namespace roadbalance
