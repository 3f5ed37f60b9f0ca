#pragma once

#include <cstdint>
#include <deque>

#include "common/types/blocks.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

/// The edges of one encoder line from a node's blocks as they come, half a second late at the most.  Nobody
/// repairs here what the bus loses: where blocks were missed stands an edge of kind kLost.
class LineEdges {
 public:
  LineEdges(std::int32_t node, int line) : node_(node), line_(line) {}

  /// A block of any node, that accept() took (common/bus/codec.hpp).
  void take(const SealedBlock& block);
  /// For the taker to remove.
  std::deque<Edge> edges;

  /// The node sends previews: it is there, and would send its edges if somebody recorded.
  bool heard_preview() const { return preview_; }
  bool heard_blocks() const { return epoch_ != 0; }

 private:
  const std::int32_t node_;
  const int line_;
  bool preview_ = false;
  std::int64_t epoch_ = 0, sequence_ = 0;
};

}  // namespace roadbalance
