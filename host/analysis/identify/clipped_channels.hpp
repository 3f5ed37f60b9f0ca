#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/clipping_detector.hpp"
#include "common/types/blocks.hpp"

namespace roadbalance {

/// Which of a node's accelerations are clipped, and in which blocks; channels are bits, as in
/// ScanBlock::overload.  A new epoch is a new device: nothing is known of it.
class ClippedChannels {
 public:
  struct Found {
    std::int32_t reached = 0;  ///< at a limit, in this block
    std::int32_t news = 0;     ///< a limit became known in this block
  };

  /// @param channels  those to watch
  explicit ClippedChannels(const NodeConfig& node, std::int32_t channels = (1 << kAccelerations) - 1);

  std::int32_t node() const { return node_.id; }

  /// Blocks of the node in their order; a hole is seen by the numbers of the scans.
  Found add(const ScanBlock& block);
  /// "front_left_z is clipped at +25 and -25 m/s², ..." for each channel of which a limit is known.
  std::vector<std::string> sentences() const;

 private:
  NodeConfig node_;
  std::vector<std::pair<std::size_t, ClippingDetector>> channel_;
  std::int64_t epoch_ = 0, next_scan_ = -1;
};

/// "is clipped at +25 and -25 m/s², though its range is 50 m/s²"; nothing: no limit is known.  For
/// people.
std::optional<std::string> clipped_clause(const ChannelConfig& channel,
                                          const ClippingDetector::Limits& limits);

}  // namespace roadbalance
