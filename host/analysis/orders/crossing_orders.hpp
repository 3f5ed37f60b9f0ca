#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/vold_kalman.hpp"
#include "common/types/block.hpp"
#include "common/types/exchange.hpp"
#include "host/analysis/orders/anti_aliasing.hpp"
#include "host/analysis/orders/mean_vector.hpp"
#include "host/analysis/orders/rotor_angle.hpp"
#include "host/analysis/orders/si_channels.hpp"

namespace roadbalance {

/// Order vectors of several rotors together in channels of one node, by the Vold-Kalman filter: a check of
/// OrderVectors, whose blocks of turns cannot separate orders that cross.
///
///     scan blocks ─▶ GridJoin ─▶ low-pass, every n-th ─▶ VoldKalmanBlocks ─▶ X once each 1/B ─▶ MeanVector
///
/// The rate goes down to what the highest order needs at kFastest_hz turns a second.  A run ends where
/// samples are missing, an angle is not known or uncertain, or a wheel turns slower than RotorOrders does or
/// faster than that. A channel's vectors within 1/B of an overload are left out, and those of orders that
/// stay together: whose phases turn by less than half a turn against one another within 1/B before and
/// behind.  The effect of the recording on an order is undone as in OrderVectors.
class CrossingOrders {
 public:
  static constexpr double kLeast_hz = 2.0, kFastest_hz = 32.0;  ///< turns of a wheel a second
  static constexpr int kMostOrders = 12;                        ///< memory and time go with its square

  struct Result {
    MeanVector all;
    std::map<int, MeanVector> by_speed;  ///< class of speed, as OrderVectors counts them
    double used_s = 0.0;
    double together_s = 0.0;  ///< that another order was too near for too long
  };

  /// @param node          whose channels, a place in VehicleConfig::node
  /// @param channel       places in its channels
  /// @param order         of each rotor: such that its phase lasts (Rotor::known_share)
  /// @param bandwidth_hz  B
  /// @throws std::invalid_argument if orders or bandwidth are not possible, saying what is
  CrossingOrders(const VehicleConfig& vehicle, std::vector<Rotor> rotor, int node,
                 std::vector<std::size_t> channel, std::vector<double> order, double bandwidth_hz);
  CrossingOrders(const CrossingOrders&) = delete;
  CrossingOrders& operator=(const CrossingOrders&) = delete;

  void consume(const SealedBlock& block) { join_.consume(block); }
  void consume(const ClockFit& fit) { join_.consume(fit); }
  /// No more blocks come.
  void finish() { end_run(); }

  const NodeConfig& node() const { return node_; }
  double bandwidth_hz() const { return filter_.bandwidth_hz; }
  /// The result of a rotor by its name, a channel by its place in the node's and an order; nothing: it was
  /// not wanted.
  const Result* find(const std::string& rotor, std::size_t channel, double order) const;
  /// Bounds of its classes of speed, turns a second.
  double class_hz(const std::string& rotor) const;

 private:
  void take(const GridJoin::Row& row);
  void take_sample(std::uint32_t overload);
  void end_run();
  void judge(const VoldKalmanBlocks::Block& block);
  void judge(const VoldKalmanBlocks::Block& block, Eigen::Index row);
  bool stays_with_another(const Eigen::MatrixXd& phase_rad, Eigen::Index row, Eigen::Index order) const;
  double order_of(Eigen::Index column) const;
  std::size_t rotor_of(Eigen::Index column) const;

  std::vector<Rotor> rotor_;
  NodeConfig node_;
  std::vector<std::size_t> channel_;
  SiChannels si_;
  std::vector<double> order_;
  AntiAliasing recorded_;
  std::vector<double> class_hz_;  ///< [rotor]
  int factor_;                    ///< samples of the node for one of the filter
  VoldKalman filter_;
  Eigen::VectorXd taps_;
  std::vector<RotorAngle> angle_;
  /// The newest taps_.size() rows, column taps_.size() - 1 the newest: channels; angles of the rotors.
  Eigen::MatrixXd values_, angles_;
  std::deque<std::uint32_t> row_overload_;
  Eigen::Index filled_ = 0;
  std::int64_t rows_ = 0;               ///< of the run
  std::deque<std::uint32_t> overload_;  ///< [filter's sample of the run from overload_from_]
  Eigen::Index overload_from_ = 0;
  std::vector<Result> result_;  ///< [channel x order of rotor]
  VoldKalmanBlocks blocks_;
  GridJoin join_;
};

}  // namespace roadbalance
