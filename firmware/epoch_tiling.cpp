#include "firmware/epoch_tiling.hpp"

#include <cmath>
#include <utility>

#include "common/link/planted.hpp"

namespace roadbalance {

std::int64_t EpochTiling::keep(const Scan& first, std::int64_t scans, std::int64_t end_ns, bool is_first_ever,
                               NodeTime now) noexcept {
  if (!first_index_) count_from(first, is_first_ever);
  const std::int64_t number = first.index - *first_index_;
  scans_sampled_ += scans;
  const std::int64_t time_ns = std::exchange(kept_end_ns_, end_ns);
  // No index can show whether a device that gave nothing before was there.
  const bool was_gone = first.after_absence || (is_first_ever && !has_extent_);
  const bool is_late = std::exchange(is_late_, false) && !first.after_absence;
  if (number > next_scan_)
    declare_jump(number - next_scan_, time_ns,
                 first.after_sleep ? GapCause::kSlept
                 : is_late         ? GapCause::kStartedLate
                 : was_gone        ? GapCause::kDeviceGone
                                   : jump_cause_,
                 now);
  next_scan_ = number + scans;
  return number;
}

std::int64_t EpochTiling::scans_between(std::int64_t from_ns, std::int64_t to_ns) const noexcept {
  return std::llround(std::max(0.0, 1e3 * static_cast<double>(to_ns - from_ns)) /
                      static_cast<double>(period_ps_));
}

void EpochTiling::count_from(const Scan& first_kept, bool is_first_ever) noexcept {
  first_index_ = first_kept.index;
  if (!started_) return;
  kept_end_ns_ = to_ns(*started_);
  if (has_instant_ && (is_late_ || !is_first_ever)) {
    // The first scan of all lies up to a period behind the instant, and a stamp may be off by a part of one.
    const double periods =
        1e3 * static_cast<double>(to_ns(first_kept.time) - kept_end_ns_) / static_cast<double>(period_ps_);
    if (periods >= 1.25) *first_index_ -= static_cast<std::int64_t>(periods);
  } else if (first_kept.after_absence || first_kept.time - *started_ > DeviceSilence::kOrdinary)
    *first_index_ -= scans_between(kept_end_ns_, to_ns(first_kept.time));
}

/// Before the scans that are kept next.
void EpochTiling::declare_jump(std::int64_t scans, std::int64_t time_ns, GapCause cause,
                               NodeTime now) noexcept {
  GapBlock jump{.header = writer_.header(next_scan_, scans, time_ns), .cause = cause};
  scans_sampled_ += scans;
  if (gap_ || !writer_.write_description(now) || !writer_.write(jump))
    lose(next_scan_, scans, time_ns, cause);
  else
    scans_missing_ += scans;
  next_scan_ += scans;
}

void EpochTiling::lose(std::int64_t first_scan, std::int64_t scans, std::int64_t time_ns,
                       GapCause cause) noexcept {
  if (planted(PlantedFault::kSilentRingFull)) return;
  if (!gap_) {
    gap_.emplace();
    gap_->cause = cause;
  }
  if (gap_->header.scans == 0) gap_->header = writer_.header(first_scan, 0, time_ns);
  gap_->header.scans += scans;
  scans_missing_ += scans;
}

bool EpochTiling::close_gap() noexcept {
  GapBlock gap = *gap_;
  if (planted(PlantedFault::kGapOffByOne) && gap.header.scans > 0) --gap.header.scans;
  if (!writer_.write(gap)) return false;
  gap_.reset();
  return true;
}

bool EpochTiling::finish() noexcept {
  return (!gap_ || close_gap()) && declare_last_of_extent() && (!silent_at_end_ || declare_last_silence());
}

bool EpochTiling::declare_last_of_extent() noexcept {
  if (!extent_end_) return true;
  if (!declare_rest(extent_end_->index - *first_index_ - next_scan_, extent_end_->ns, jump_cause_))
    return false;
  extent_end_.reset();
  return true;
}

/// Up to the stop, behind all that was kept.
bool EpochTiling::declare_last_silence() noexcept {
  if (next_scan_ == 0) kept_end_ns_ = to_ns(started_.value_or(*silent_at_end_));
  const std::int64_t until_ns = to_ns(*silent_at_end_);
  if (!declare_rest(scans_between(kept_end_ns_, until_ns), until_ns, GapCause::kDeviceGone)) return false;
  silent_at_end_.reset();
  return true;
}

bool EpochTiling::declare_rest(std::int64_t scans, std::int64_t until_ns, GapCause cause) noexcept {
  if (scans <= 0) return true;
  GapBlock gap{.header = writer_.header(next_scan_, scans, kept_end_ns_), .cause = cause};
  if (!writer_.write(gap)) return false;
  scans_sampled_ += scans;
  scans_missing_ += scans;
  next_scan_ += scans;
  kept_end_ns_ = until_ns;
  return true;
}

EndBlock EpochTiling::end_block(NodeTime now) const noexcept {
  return {.header = writer_.header(next_scan_, 0, end_ns(now)),
          .blocks = writer_.next_sequence(),
          .scans_sealed = scans_sampled_ - scans_missing_,
          .scans_missing = scans_missing_,
          .blocks_crc32c = writer_.blocks_crc32c()};
}

}  // namespace roadbalance
