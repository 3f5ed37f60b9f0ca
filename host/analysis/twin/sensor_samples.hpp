#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/decimating_filter.hpp"
#include "common/types/block.hpp"
#include "common/types/exchange.hpp"
#include "host/analysis/identify/common_rows.hpp"
#include "host/analysis/twin/twin_channels.hpp"

namespace roadbalance {

/// One instant of the twin's channels, at the identification rate.
struct SensorSample {
  std::int64_t time_ns = 0;  ///< of the instant, on the time line all nodes share
  bool restart = false;      ///< samples are missing before it
  /// [channels + 8]: m/s^2 in the order of TwinChannels, then cos, sin of each wheel's angle; 0, 0: not
  /// known.
  Eigen::VectorXd values;
};

/// Blocks of all nodes -> the twin's channels one by one on the common grid, through the low-pass and to the
/// rate of identification.  Rows that a node lacks or that left their range are passed over: the sample after
/// is a restart.
class SensorSamples {
 public:
  using Emit = std::function<void(const SensorSample&)>;

  /// @throws ConfigError if identification needs more samples than the nodes take
  SensorSamples(const VehicleConfig& vehicle, const TwinChannels& channels, Emit emit);

  /// Rate of the samples that come out.
  static double rate_hz(const VehicleConfig& vehicle);

  void consume(const SealedBlock& block);
  void consume(const ClockFit& fit);

  /// Why a node's samples cannot be brought to the grid of the others; empty: all can.
  std::string no_common_time() const { return rows_.refusal(); }

 private:
  struct NodeMap {
    Eigen::MatrixXd from_counts;  ///< [values x 16]
    std::array<std::optional<int>, kEncoderLines> wheel;
  };
  void take_runs();
  void add_node(const GridStream& stream, const NodeMap& map, const CommonRows::Run& run);
  void decimate(const CommonRows::Run& run);

  CommonRows rows_;
  std::vector<NodeMap> maps_;
  Eigen::VectorXd at_zero_counts_;
  Eigen::MatrixXd samples_;  ///< [values x rows] of a run
  std::int64_t behind_;      ///< rows, of the instant that a sample is of behind the last one in it
  DecimatingFilter low_pass_;
  bool restart_ = true;
  SensorSample sample_;
  Emit emit_;
};

}  // namespace roadbalance
