#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>

#include "common/bus/codec.hpp"
#include "common/types/bounded_time.hpp"
#include "host/recording/formats/epoch_clock.hpp"
#include "host/recording/subset/epoch_sink.hpp"
#include "host/recording/subset/pieces.hpp"

namespace roadbalance {

/// Cuts one recorded node epoch at the borders of pieces: each piece goes into a sink of its own.
///
/// A scan belongs to the piece in which it was taken, an edge and a signal's sample to the piece in which
/// they were stamped.  While the time is unknown (behind a break of the node's clock) scans follow those
/// before them.  An undeclared loss becomes a gap of cause kLostInRecord.
class SubsetEpoch {
 public:
  using Begin = std::function<std::unique_ptr<EpochSink>(std::size_t piece)>;

  /// @param clock, pieces  outlive it; the clock takes each event before this does
  /// @param kept           bit k: channel k of the scans is kept, else its counts become 0
  /// @param begin          makes the sink of a piece; called once for each
  SubsetEpoch(const EpochClock& clock, const Pieces& pieces, std::int64_t period_ps, std::uint32_t kept,
              Begin begin);

  /// The next block of the epoch, in sequence.
  void take(const SealedBlock& block);
  /// The recording has ended.
  void finish();

 private:
  void take_scans(ScanBlock block);
  void take_gap(const GapBlock& gap);
  void missing(std::int64_t scans, GapCause cause);
  void close_hole(std::int64_t next_scan, std::int64_t time_ns);
  template <typename Run>
  void by_piece(std::int64_t begin_ns, std::int64_t count, Run&& run);
  template <typename Item, typename Give>
  void items(std::span<const Item> items, Give&& give);
  void end_older_than(std::int64_t time_ns);
  std::int64_t after(std::int64_t begin_ns, std::int64_t scans) const {
    return time_after_ns(begin_ns, scans, period_ps_);
  }
  std::optional<std::int64_t> time_of(std::int64_t begin_ns, std::int64_t scans) const {
    return clock_.time_ns(after(begin_ns, scans));
  }
  /// nullptr: the piece has ended.
  EpochSink* sink(std::size_t piece);

  const EpochClock& clock_;
  const Pieces& pieces_;
  std::int64_t period_ps_;
  const std::uint32_t kept_;
  const Begin begin_;
  std::map<std::size_t, std::unique_ptr<EpochSink>> open_;
  std::size_t ended_pieces_ = 0;         ///< all before this one
  std::optional<std::size_t> at_piece_;  ///< of the last scan
  std::optional<GapCause> lost_;  ///< blocks with an unknown number of scans are lost behind the last one
  std::int64_t last_sequence_ = 0;
  std::int64_t next_scan_ = -1;                                         ///< -1: none has come yet
  std::int64_t end_ns_ = 0;                                             ///< node time of next_scan_
  std::int64_t reached_ns_ = std::numeric_limits<std::int64_t>::min();  ///< the same on the recording's clock
  bool crashed_ = false, ended_ = false;
};

}  // namespace roadbalance
