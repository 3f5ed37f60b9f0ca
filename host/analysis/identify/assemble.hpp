#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/types/block.hpp"
#include "common/types/exchange.hpp"
#include "common/vehicle/linear_model.hpp"
#include "common/vehicle/sensor_map.hpp"
#include "host/analysis/identify/clipped_channels.hpp"
#include "host/analysis/identify/common_rows.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {

/// True if one channel of role road sits at every wheel.
bool measures_road(const VehicleConfig& vehicle);

/// Joins the scan blocks of all nodes to runs of signals on one grid of time.
///
/// The grid is that of the block that comes first: its time and period; GridStream brings each node's samples
/// to it. Rows that one node lacks, and blocks in which a channel left its range or was at a limit where it
/// is clipped (ClippedChannels), are left out; the run after them is marked `restart`, so no estimate runs
/// across a hole.  The run after the block that made the limit known is marked `spoiled`, too: tops may have
/// been cut off before.  The road is in the runs if a channel measures it at every wheel. A wheel whose angle
/// is not known has the reference 0.  The result depends on the blocks and fits of each node in their order
/// only, but for the grid not on how the nodes' blocks interleave, as long as no node is kLongestWait_s
/// behind: then the others go on without it.
class Assembler {
 public:
  /// Seconds of drive, not of waiting: faster than real time one node may be a whole ring ahead of another
  /// and more. Half an hour at 2 kHz is 250 MB a node.
  static constexpr double kLongestWait_s = 1800.0;
  using Emit = std::function<void(const SignalRun&)>;

  /// @throws ConfigError if the sensors do not determine the seven coordinates
  Assembler(const VehicleConfig& vehicle, Emit emit, double longest_wait_s = kLongestWait_s)
      : Assembler(vehicle, SensorMap::from(vehicle), std::move(emit), longest_wait_s) {}
  Assembler(const VehicleConfig& vehicle, const SensorMap& sensors, Emit emit,
            double longest_wait_s = kLongestWait_s);

  void consume(const SealedBlock& block);
  /// How a node's clock stands to the host's, for the blocks of that node that come next.
  void consume(const ClockFit& fit);

  /// A sentence for each channel that is clipped, whose blocks are left out.  For people.
  std::vector<std::string> clipped() const;
  /// Why a node's samples cannot be brought to the grid of the others; empty: all can.
  std::string no_common_time() const { return rows_.refusal(); }

 private:
  /// Where signals come from: `from_counts` times the 16 channels of that node.
  struct NodeMap {
    Eigen::Matrix<double, kSignals, kChannels> from_counts;
    std::vector<Eigen::Index> used;  ///< channels whose column is not 0
    SignalVector at_zero_counts;
    /// Its channels that are SensorMap's inputs, and how they read.
    struct Reading {
      Eigen::Index input, channel;
      double m_s2_per_count, at_zero_counts;
    };
    std::vector<Reading> readings;
    Eigen::Matrix<double, kWheels, kChannels> road_from_counts;
    Eigen::Vector4d road_at_zero_counts;
    std::int32_t overload_mask;
    std::array<std::optional<int>, kEncoderLines> wheel;  ///< by encoder line
  };

  void emit();
  void add_rows(const GridStream& stream, const NodeMap& map);
  void add_road(NodeMap& map, const NodeConfig& node) const;
  void emit_run(const CommonRows::Run& run);

  CommonRows rows_;
  std::vector<NodeMap> maps_;
  Eigen::Index inputs_;                   ///< of SensorMap
  std::vector<ClippedChannels> clipped_;  ///< of the nodes in rows_
  bool road_measured_;
  SignalRun run_;
  Emit emit_;
};

}  // namespace roadbalance
