#pragma once

#include <cstdint>
#include <optional>

#include "common/types/block.hpp"

namespace roadbalance {

/// Time against scan index of one epoch, from its blocks: the instants of gaps that are declared between
/// them.  Blocks may carry any values within their bounds; an instant worked out stays within kClockLimit_ns.
class ScanLine {
 public:
  /// Only blocks of these kinds carry the scan they begin at.
  static bool carries_scan(BlockKind kind);

  /// The block that follows, of any kind.
  void take(BlockKind kind, const BlockHeader& header);
  /// The instant of a scan behind the last block that had scans: on the line from it to `behind`, the next
  /// one that has; without, or if it lies before, on that through the last two.  In an epoch of which none
  /// was taken, the instant of `behind`, or nothing.
  std::optional<std::int64_t> time_ns(std::int64_t scan, const BlockHeader* behind) const;

 private:
  std::optional<BlockHeader> last_;
  double ns_per_scan_ = 0.0;  // between the last two
};

}  // namespace roadbalance
