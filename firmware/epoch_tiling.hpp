#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "common/types/blocks.hpp"
#include "common/types/clocks.hpp"
#include "common/types/scan.hpp"
#include "firmware/block_writer.hpp"

namespace roadbalance {

/// Whether a device that should give scans all the time gives none, by its own clock.
///
/// A device may take a moment to begin, and scans may be on their way: a second is no silence.  Nor is time
/// in which no read was made, as by a process that was not scheduled: a read waits no longer than
/// kLongestRead.
class DeviceSilence {
 public:
  static constexpr NodeClock::duration kOrdinary = std::chrono::seconds(1);

  /// A read has returned, at `now` by the device's clock.
  /// @param scans  how many the device has given so far
  void asked(NodeTime now, std::int64_t scans) noexcept {
    const auto waited = asked_ ? std::min(now - *asked_, kLongestRead) : NodeClock::duration{};
    in_vain_ = scans != scans_ ? NodeClock::duration{} : in_vain_ + waited;
    scans_ = scans;
    asked_ = now;
  }
  /// When a read returned last; nothing: none has.
  std::optional<NodeTime> asked() const noexcept { return asked_; }
  /// It is not there.
  bool is_long() const noexcept { return in_vain_ > kOrdinary; }

 private:
  static constexpr NodeClock::duration kLongestRead = std::chrono::milliseconds(100);

  std::optional<NodeTime> asked_;
  std::int64_t scans_ = 0;
  NodeClock::duration in_vain_{};  ///< reads since one gave scans
};

/// Tiles the scans [0, end) of an epoch with scan blocks and gaps, each gap with its exact range and cause.
///
/// Scans that the device lost are declared at once.  If the sink has no room they, and the scans that are
/// lost for want of room, become one gap that grows until close_gap().  Never allocates.
class EpochTiling {
 public:
  /// @param period_ps  between scans
  /// @param jump       cause of a jump in the device's scan index unless the device was absent
  EpochTiling(BlockWriter& writer, std::int64_t period_ps, GapCause jump)
      : writer_(writer), period_ps_(period_ps), jump_cause_(jump) {}
  EpochTiling(const EpochTiling&) = delete;
  EpochTiling& operator=(const EpochTiling&) = delete;

  /// See DeviceSilence.
  void asked(NodeTime now, std::int64_t scans) noexcept { silence_.asked(now, scans); }
  bool is_silent() const noexcept { return silence_.is_long(); }
  /// The epoch begins: scans that a device has not given since then are missing.
  /// @param at       NodeTime::min(): now
  /// @param is_late  the device gave scans of behind that instant, which are not kept
  void start(NodeTime at, bool is_late) noexcept {
    started_ = silence_.asked();
    has_instant_ = started_.has_value() && at != NodeTime::min();
    if (has_instant_) started_ = at;
    is_late_ = is_late;
  }
  /// The epoch ends: a device that is silent has lost scans until then.
  /// @param at  NodeTime::min(): now
  void stop(NodeTime at) noexcept {
    if (!silence_.is_long()) return;
    silent_at_end_ = silence_.asked();
    if (at != NodeTime::min()) silent_at_end_ = std::min(*silent_at_end_, at);
  }

  /// Of a source whose extent is known though it may lack scans at both ends: the epoch counts from the
  /// scan of this index, which may be missing.  Before the first keep().
  void begin_at(std::int64_t index, NodeTime time) noexcept {
    first_index_ = index;
    kept_end_ns_ = to_ns(time);
    has_extent_ = true;
  }
  /// ... and ends before the scan of this index.  Before finish().
  void end_at(std::int64_t index, NodeTime time) noexcept { extent_end_ = {index, to_ns(time)}; }

  /// `scans` scans are kept; those missing before them are declared.
  /// @param first    of them
  /// @param end_ns   one period after the last of them
  /// @param is_first_ever  nothing was sealed before them
  /// @return the number of the first in the epoch
  std::int64_t keep(const Scan& first, std::int64_t scans, std::int64_t end_ns, bool is_first_ever,
                    NodeTime now) noexcept;
  /// Scans for which the sink has no room.
  void lose(std::int64_t first_scan, std::int64_t scans, std::int64_t time_ns, GapCause cause) noexcept;
  /// The same of what lies beside scans: a gap that covers none as yet.
  void lose_beside(NodeTime now) noexcept { lose(next_scan_, 0, end_ns(now), GapCause::kRingFull); }

  /// The gap that grows; nullptr if there is none.
  const GapBlock* gap() const noexcept { return gap_ ? &*gap_ : nullptr; }
  /// Writes the gap.  False if the sink has no room.
  bool close_gap() noexcept;
  /// Writes what is missing at the end.  False if the sink has no room.
  bool finish() noexcept;
  EndBlock end_block(NodeTime now) const noexcept;

  /// Number in the epoch, after the last one kept or declared.
  std::int64_t next_scan() const noexcept { return next_scan_; }
  /// Kept or declared missing.
  std::int64_t scans_sampled() const noexcept { return scans_sampled_; }
  std::int64_t scans_missing() const noexcept { return scans_missing_; }

 private:
  std::int64_t scans_between(std::int64_t from_ns, std::int64_t to_ns) const noexcept;
  std::int64_t end_ns(NodeTime now) const noexcept { return next_scan_ > 0 ? kept_end_ns_ : to_ns(now); }
  void count_from(const Scan& first_kept, bool is_first_ever) noexcept;
  void declare_jump(std::int64_t scans, std::int64_t time_ns, GapCause cause, NodeTime now) noexcept;
  bool declare_last_of_extent() noexcept;
  bool declare_last_silence() noexcept;
  bool declare_rest(std::int64_t scans, std::int64_t until_ns, GapCause cause) noexcept;

  BlockWriter& writer_;
  const std::int64_t period_ps_;
  const GapCause jump_cause_;
  DeviceSilence silence_;
  std::optional<NodeTime> started_;  ///< by the device's clock
  bool has_instant_ = false;         ///< it was appointed
  bool is_late_ = false;
  std::optional<NodeTime> silent_at_end_;  ///< until then, and not yet declared
  bool has_extent_ = false;                ///< first_index_ was given
  struct End {
    std::int64_t index, ns;
  };
  std::optional<End> extent_end_;  ///< not yet declared
  /// Device index that the epoch counts from, once a scan is kept: that one's, or before it by what is
  /// missing since the start.
  std::optional<std::int64_t> first_index_;
  std::int64_t next_scan_ = 0;
  std::int64_t kept_end_ns_ = 0;  ///< one period after the last one kept or lost
  std::optional<GapBlock> gap_;   ///< of a full sink, growing
  std::int64_t scans_sampled_ = 0;
  std::int64_t scans_missing_ = 0;
};

}  // namespace roadbalance
