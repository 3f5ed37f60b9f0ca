#pragma once

#include <array>
#include <utility>

#include "common/types/scan.hpp"

namespace roadbalance {

/// Puts a mark before the first edge of a line that follows dropped ones, so that a reader that counts teeth
/// sees the hole.  Never allocates.
class DroppedEdges {
 public:
  /// An edge of this line is not passed on.
  /// @return true if that begins a hole, which is counted once, however many edges it has
  [[nodiscard]] bool drop(std::uint8_t line) noexcept { return !std::exchange(dropped_[line], true); }

  /// Pushes the edge; after dropped ones of its line a mark of kLost first, a nanosecond earlier.
  /// @param push  bool(const Edge&): false if there is no room
  /// @return false if there was no room for both: the edge is to be dropped
  template <typename Push>
  [[nodiscard]] bool pass(const Edge& edge, Push push) noexcept {
    const Edge lost{.time = edge.time - NodeClock::duration(1), .line = edge.line, .kind = EdgeKind::kLost};
    const bool is_marked = !dropped_[edge.line] || edge.kind == EdgeKind::kLost;
    if ((!is_marked && !push(lost)) || !push(edge)) return false;
    dropped_[edge.line] = false;
    return true;
  }

 private:
  std::array<bool, kEncoderLines> dropped_{};
};

}  // namespace roadbalance
