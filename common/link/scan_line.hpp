#pragma once

#include <cstdint>
#include <optional>

#include "common/link/block.hpp"

namespace roadbalance {

/// Time against scan index of one epoch, as its blocks tell it: the instants of gaps that are declared
/// between them.  Blocks may say of both what their bounds allow; an instant worked out stays within
/// kClockLimit_ns.
class ScanLine {
 public:
  /// Only blocks of these kinds say which scan they begin at.
  static bool is_told_by(BlockKind kind);

  /// The block that follows, of any kind.
  void take(BlockKind kind, const BlockHeader& header);
  /// The instant of a scan behind the last block that told of scans: on the line from it to `behind`, the
  /// next one that does; without, or if it lies before, on that through the last two.  Of an epoch none was
  /// taken of that of `behind`, or nothing.
  std::optional<std::int64_t> time_ns(std::int64_t scan, const BlockHeader* behind) const;

 private:
  std::optional<BlockHeader> last_;
  double ns_per_scan_ = 0.0;  // between the last two
};

}  // namespace roadbalance
