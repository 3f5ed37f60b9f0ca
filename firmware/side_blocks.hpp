#pragma once

#include <cstddef>
#include <cstdint>

#include "common/frontend/dropped_edges.hpp"
#include "common/types/blocks.hpp"
#include "firmware/block_writer.hpp"
#include "firmware/epoch_tiling.hpp"

namespace roadbalance {

/// Edges and signal samples, which are recorded beside the scans as they came.
///
/// Signals are written within 0.2 s; edges too, but those of slow wheels once there are 350, or after 1 s.  A
/// full sink is waited for with one block of each; when that is full too, edges and samples are lost within
/// the gap, and the first edge of a line behind lost ones follows a mark of kLost.  Never allocates.
class SideBlocks {
 public:
  SideBlocks(BlockWriter& writer, EpochTiling& tiling) : writer_(writer), tiling_(tiling) {}
  SideBlocks(const SideBlocks&) = delete;
  SideBlocks& operator=(const SideBlocks&) = delete;

  void add(const Edge& edge, NodeTime now) noexcept;
  void add(const SignalSample& sample, NodeTime now) noexcept;
  /// Writes what is waiting, before the gap that is open or behind the last scan.  False if the sink has no
  /// room.
  bool write_all(NodeTime now) noexcept;
  /// The same for a block that has waited long enough, if the sink has room.
  void write_old(NodeTime now) noexcept;

  /// Latest stamp of an edge or sample for which there was no room.
  NodeTime lost_through() const noexcept { return lost_through_; }
  /// Blocks that so many edges and samples can become at most in so long.
  static std::size_t most_blocks(std::size_t edges, std::size_t signals, std::int64_t all_ns) noexcept;

 private:
  template <typename Item, typename Block>
  bool place(const Item& item, Block& block, NodeTime now) noexcept;
  template <typename Block>
  bool write(Block& block, NodeTime now) noexcept;
  void lose(NodeTime time, NodeTime now) noexcept;

  BlockWriter& writer_;
  EpochTiling& tiling_;
  EdgeBlock edge_block_;
  SignalBlock signal_block_;
  DroppedEdges dropped_;
  NodeTime lost_through_{};
};

}  // namespace roadbalance
