#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/link/blocks.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/identify/signals.hpp"

namespace roadbalance {

/// Joins the scan blocks of all nodes to runs of signals on one grid of time.
///
/// The grid is that of the first block: its time and period.  Rows that one node lacks, and blocks with
/// overload or off the grid, are left out; the run after them is marked `restart`, so no estimate runs across
/// a hole.  A wheel whose angle is not known has the reference 0.  The result depends on the blocks of each
/// node in their order only, not on how the nodes' blocks interleave, as long as no node is kLongestWait_s
/// behind: then the others go on without it.
class Assembler {
 public:
  /// Of drive, not of waiting: faster than real time one node may be a whole ring ahead of another and more.
  /// Half an hour at 2 kHz is 250 MB a node.
  static constexpr double kLongestWait_s = 1800.0;
  using Emit = std::function<void(const SignalRun&)>;

  /// @throws ConfigError if the sensors do not determine the seven coordinates
  Assembler(const VehicleConfig& vehicle, Emit emit, double longest_wait_s = kLongestWait_s);

  void consume(const SealedBlock& block);

  /// What was wrong with a block that was left out because its samples do not lie on the grid; empty: none
  /// was.
  const std::string& off_grid() const { return off_grid_; }

 private:
  struct Stream {
    int id;
    std::deque<ScanBlock> blocks;
    std::int64_t row = 0;  ///< of the front block, next to use
  };
  /// Where signals come from: `from_counts` times the 16 channels of that node.
  struct NodeMap {
    Eigen::Matrix<double, kSignals, kChannels> from_counts;
    SignalVector at_zero_counts;
    std::int32_t overload_mask;
    std::array<std::optional<int>, kEncoderLines> wheel;  ///< by encoder line
  };

  void drop_unusable(Stream& stream, const NodeMap& map);
  void drop_what_nobody_meets();
  bool on_grid(const ScanBlock& block);
  std::int64_t grid_index(const Stream& stream) const;
  void add_rows(const Stream& stream, const NodeMap& map);
  void emit_common_rows();

  std::vector<Stream> streams_;
  std::vector<NodeMap> maps_;
  std::optional<std::int64_t> origin_ns_;
  std::int64_t period_ps_ = 0;
  std::int64_t expected_ = -1;
  std::string off_grid_;
  double longest_wait_s_;
  SignalRun run_;
  Emit emit_;
};

}  // namespace roadbalance
