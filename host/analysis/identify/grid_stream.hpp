#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/clock/clock_table.hpp"
#include "host/analysis/identify/channel_aligner.hpp"
#include "host/analysis/identify/grid.hpp"
#include "host/analysis/identify/resampler.hpp"
#include "host/analysis/identify/row_queue.hpp"

namespace roadbalance {

/// Brings the scan blocks of one node to the grid.
///
/// A node of whose clock no fit was ever heard has the grid's time; while its samples lie on the grid they
/// are its rows unchanged, else they are resampled, to the end of the epoch.  A node with a clock of its own
/// is resampled always: each block by the fits that came before it (ClockMap), live and later alike.  Blocks
/// that come before the first fit, or after a break of the time base, wait for the next one, at most
/// kLongestWait_s.  Before all that ChannelAligner takes off by how much channels lag.
class GridStream {
 public:
  static constexpr double kLongestWait_s = 60.0;  ///< of drive; older blocks are left out

  /// @param alone  the only node there is: its own time will do
  GridStream(std::int32_t node, bool alone, const ChannelDelays& delays = {})
      : node_(node), alone_(alone), aligner_(delays) {}

  std::int32_t node() const { return node_; }
  /// A fit that a segment only repeats is ignored.
  void take(const ClockFit& fit, Grid& grid);
  /// The first block of all sets the grid.
  void take(const ScanBlock& block, Grid& grid);

  RowQueue rows;           ///< for the taker to remove, ascending
  std::int64_t row = 0;    ///< of the front, next to use
  bool spoiled = false;    ///< nothing before the next row to use is good
  bool restarted = false;  ///< rows up to the next to use do not go on from those used before

  /// Why its samples cannot be brought to the grid at present; empty: they can.
  std::string refusal() const;

 private:
  struct Clock {
    std::int64_t epoch;
    ClockMap map;
    std::int64_t breaks = 0;
    int distrusted = 0;  ///< so many fits may still be from before a jump, unless they report a break
  };
  void take_aligned(const ScanBlock& block, Grid& grid);
  Clock* clock_of(std::int64_t epoch);
  Clock& declare(std::int64_t epoch);
  double awaited_s() const;
  bool jumps(const ScanBlock& block, const Clock& clock) const;
  void place(const ScanBlock& block, const ClockMap* map, Grid& grid);
  void measure_spacing(const ScanBlock& block, const ClockMap* map, bool follows, const Grid& grid);
  void copy(const ScanBlock& block, double position, bool same_epoch);
  void queue(const GridRows& more);

  const std::int32_t node_;
  const bool alone_;
  ChannelAligner aligner_;
  ClockTable heard_;
  std::deque<Clock> clocks_;          ///< of epochs that have their own, the latest ones
  std::deque<ScanBlock> waiting_;     ///< for a fit
  std::int64_t other_period_ps_ = 0;  ///< of a block that was refused; 0: none was
  /// The block that came last, and the one placed last.
  struct Last {
    std::int64_t epoch = 0;
    std::int64_t next_scan = -1;
    std::int64_t scans = 0;
    std::int64_t time_ns = 0;

    bool goes_on_with(const BlockHeader& header) const {
      return header.epoch == epoch && header.first_scan == next_scan;
    }
  };
  static Last last_of(const ScanBlock& block);
  Last came_, placed_;
  std::optional<std::int64_t> came_host_ns_;  ///< of the block that came last, if a fit gives it
  double spacing_ = 0.0;                      ///< of samples, in periods; 0: not measured in this epoch
  bool resampling_ = false;
  std::unique_ptr<Resampler> resampler_;
  std::vector<GridRows> resampled_;
};

}  // namespace roadbalance
