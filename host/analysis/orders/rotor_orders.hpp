#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/orders/angle_resampler.hpp"
#include "host/analysis/orders/fewer_samples.hpp"
#include "host/analysis/orders/grid_join.hpp"
#include "host/analysis/orders/order_vectors.hpp"
#include "host/analysis/orders/order_waterfall.hpp"
#include "host/analysis/orders/rotor.hpp"
#include "host/analysis/orders/rotor_angle.hpp"
#include "host/analysis/orders/si_channels.hpp"

namespace roadbalance {

/// Orders of a wheel, or of what wheels turn, in channels of one node.
///
///     scan blocks ─▶ GridJoin ─▶ angle, channels ─▶ FewerSamples ─▶ AngleResampler
///
///     AngleResampler ─┬▶ blocks of 32 turns ─▶ OrderWaterfall
///                     └▶ blocks of 8 turns ──▶ OrderVectors
///
/// Where channels and angle are of one node no clock comes between; else all are brought to common instants.
/// Where the angle of a wheel is not known, or a turn had not exactly its teeth, or scans are missing, or the
/// rotor turns slower than kLeastRotation_hz, nothing is used; an overload takes its channel out of the
/// blocks it touches.  Memory does not grow with the drive.
class RotorOrders {
 public:
  static constexpr int kRowsPerTurn = 64;
  static constexpr int kSpectrumTurns = 32;
  static constexpr int kVectorTurns = 8;
  static constexpr double kLeastRotation_hz = 2.0;  ///< of a wheel: 13 km/h

  /// How much is computed; most of the cost goes with the inverse of the least rotation.
  struct Effort {
    bool spectra = true;  ///< else vectors only
    double least_rotation_hz = kLeastRotation_hz;
    int vector_turns = kVectorTurns;  ///< of a block of the vectors; fewer leave a short record more blocks
    double highest_hz = 0.0;          ///< of lines that are wanted; 0: all that the sampling rate carries
    double longest_wait_s = GridJoin::kLongestWait_s;  ///< for a node that is behind, in drive

    bool operator==(const Effort&) const = default;
  };

  /// Seconds of the drive; those that are not used, by their reason.
  struct Seconds {
    double recorded = 0.0;
    double no_angle = 0.0;   ///< a node did not have its wheel's angle
    double uncertain = 0.0;  ///< known, but a turn did not have exactly its teeth
    double slow = 0.0;
  };
  /// From the begin of the first block that the vectors are of to the end of the last, s by the samples that
  /// came before; missing ones do not count.
  struct Stretch {
    double from_s, to_s;
  };

  /// @param rotor    of wheels with an encoder
  /// @param node     whose channels, a place in VehicleConfig::node
  /// @param channel  places in its channels; at least one
  /// @param order    of the vectors
  /// @throws std::invalid_argument if vectors of these orders cannot be had
  RotorOrders(const VehicleConfig& vehicle, Rotor rotor, int node, std::vector<std::size_t> channel,
              std::vector<double> order)
      : RotorOrders(vehicle, std::move(rotor), node, std::move(channel), std::move(order), Effort{}) {}
  RotorOrders(const VehicleConfig& vehicle, Rotor rotor, int node, std::vector<std::size_t> channel,
              std::vector<double> order, const Effort& effort);
  RotorOrders(const RotorOrders&) = delete;
  RotorOrders& operator=(const RotorOrders&) = delete;

  /// Blocks of all nodes, those of each in sequence, and the fits of their clocks between them.
  void consume(const SealedBlock& block) { join_.consume(block); }
  void consume(const ScanBlock& block) { join_.consume(block); }
  void consume(const ClockFit& fit) { join_.consume(fit); }

  /// Whether both want the same of the same nodes and channels, and only their rotors differ.
  bool can_share_with(const RotorOrders& other) const;
  /// From here on what this one consumes is for `other`, too, which consumes nothing and lives as long:
  /// blocks are decoded, aligned and low-passed once for both.  Before the first block; needs
  /// can_share_with().
  void share_with(RotorOrders& other);

  const Rotor& rotor() const { return rotor_; }
  const NodeConfig& node() const { return node_; }
  const std::vector<std::size_t>& channel() const { return channel_; }
  const std::vector<double>& order() const { return order_; }
  double way_m() const { return way_m_; }  ///< of the car in a turn of the rotor
  Seconds seconds() const;
  const std::optional<Stretch>& stretch() const { return stretch_; }  ///< nothing: there is no block
  std::int64_t gaps() const { return gaps_; }
  /// Why nodes' scans cannot be brought to each other; empty: they can.
  std::string refusal() const { return join_.refusal(); }
  /// Channels are counted as in channel().
  const OrderWaterfall& waterfall() const { return waterfall_; }
  const OrderVectors& vectors() const { return vectors_; }

 private:
  void take(const GridJoin::Row& row);
  void restart();
  void give_angle(const GridJoin::Row& row, FewerSamples& fewer, std::size_t which);

  Rotor rotor_;
  NodeConfig node_;
  std::vector<std::int32_t> joined_;  ///< nodes, by their number
  std::vector<std::size_t> channel_;
  std::vector<double> order_;
  double way_m_;
  Effort effort_;
  RotorAngle angle_;
  OrderWaterfall waterfall_;
  OrderVectors vectors_;
  TurnBlocks spectrum_blocks_, vector_blocks_;
  std::optional<Stretch> stretch_;
  int factor_;  ///< samples of which the resampler gets one
  AngleResampler resampler_;
  std::vector<RotorOrders*> sharing_{this};
  FewerSamples fewer_;
  SiChannels si_;
  Eigen::VectorXd values_;
  GridJoin join_;
  std::int64_t rows_ = 0, no_angle_ = 0, uncertain_ = 0, gaps_ = 0;
};

}  // namespace roadbalance
