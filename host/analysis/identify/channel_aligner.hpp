#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/fractional_delay.hpp"
#include "common/types/blocks.hpp"

namespace roadbalance {

/// By how much each of a node's channels lags, s; the references lag nothing.
using ChannelDelays = std::array<double, kChannels>;
ChannelDelays delays_of(const NodeConfig& node);

/// One node's scan blocks, each channel brought forward by its delay: what all channels of a row show is of
/// one instant.
///
/// A channel that lags by d shows at t + d what was at t: its samples are taken there with FractionalDelay,
/// rounded to counts.  Rows whose samples are not all there (at most kAfter and the longest delay on either
/// side of a hole) are left out.  Overload and quality are those of every sample that a row could be made of.
/// Without delays blocks pass as they are.
class ChannelAligner {
 public:
  using Emit = std::function<void(const ScanBlock&)>;

  explicit ChannelAligner(const ChannelDelays& delays) : delays_(delays) {}

  /// Blocks as they come; `emit` gets what is complete now, at most one block for each.
  void add(const ScanBlock& block, const Emit& emit);

 private:
  struct Row {
    std::array<std::int32_t, kChannels> counts;
    std::int64_t scan, time_ns;
    std::int32_t overload, quality;
  };
  struct Delayed {
    std::size_t channel;
    std::int64_t whole;  ///< samples
    FractionalDelay::Taps taps;
  };
  void begin(const ScanBlock& block);
  void fill(ScanBlock& out, std::int64_t row) const;

  ChannelDelays delays_;
  std::vector<Delayed> delayed_;          ///< at the rate of the run
  std::int64_t before_ = 0, behind_ = 0;  ///< rows that one needs around it
  std::deque<Row> rows_;   ///< of the run; those before the next to emit as far as it needs them
  std::int64_t next_ = 0;  ///< to emit, place in rows_
  std::int64_t epoch_ = 0, next_scan_ = -1;
};

}  // namespace roadbalance
