#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/types/block.hpp"
#include "common/types/blocks.hpp"
#include "common/types/exchange.hpp"
#include "host/analysis/identify/grid_stream.hpp"

namespace roadbalance {

/// The scans of some nodes on one grid of time, side by side: finds the rows that all of them have.
///
/// Rows that one node lacks are passed over, and the next run is a restart.  A node that is behind for longer
/// than it may be is not waited for.
class CommonRows {
 public:
  /// Rows that each node has at the front of its stream, from its `row` on.
  struct Run {
    std::int64_t first_index;
    std::int64_t rows;
    bool restart;          ///< it does not go on from the run before
    bool spoiled = false;  ///< the runs before it, since the last restart, are not to be used
  };

  /// @param longest_wait_s  for a node that is behind, of drive
  explicit CommonRows(double longest_wait_s) : longest_wait_s_(longest_wait_s) {}

  /// Before the first block.
  /// @param alone     the only node there will be: its own time will do
  /// @param unusable  channels that leave a row out if one of them left its range, as bits of
  ///                  ScanBlock::overload; by kChannels higher: and spoil what was before it
  void add(const NodeConfig& node, bool alone, std::int32_t unusable = 0);

  /// False: it is none of a node here, or no block of scans.
  bool take(const SealedBlock& block);
  /// For who has decoded it already.
  bool take(const ScanBlock& block);
  /// In the order of the record: a fit counts for the blocks of its node that come after it.
  bool take(const ClockFit& fit);

  /// The next run; nothing if a node has no row left.  use() passes it.
  std::optional<Run> next();
  void use(const Run& run);
  /// After all that next() gives: a node that stays away must not make the others' rows pile up.
  void drop_what_nobody_meets();

  /// Why a node's samples cannot be brought to the grid of the others at present; empty: all can.
  std::string refusal() const;

  const std::vector<GridStream>& streams() const { return streams_; }  ///< as they were added
  const Grid& grid() const { return grid_; }

 private:
  GridStream* stream_of(std::int32_t node);
  bool drop_unusable(std::size_t which);
  bool align();

  std::vector<GridStream> streams_;
  std::vector<std::int32_t> unusable_;
  Grid grid_;
  std::int64_t expected_ = -1;
  double longest_wait_s_;
};

}  // namespace roadbalance
