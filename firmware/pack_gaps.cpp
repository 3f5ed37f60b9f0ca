#include <algorithm>
#include <cmath>

#include "common/link/planted.hpp"
#include "firmware/pack.hpp"

// What is missing, and how the record is told.
namespace roadbalance {

std::int64_t Sealer::scans_between(std::int64_t from_ns, std::int64_t to_ns) const noexcept {
  return std::llround(std::max(0.0, 1e3 * static_cast<double>(to_ns - from_ns)) /
                      static_cast<double>(period_ps_));
}

void Sealer::count_from(const Scan& first_kept) noexcept {
  first_index_ = first_kept.index;
  if (!started_) return;
  kept_end_ns_ = to_ns(*started_);
  if (first_kept.after_absence || first_kept.time - *started_ > DeviceSilence::kOrdinary)
    *first_index_ -= scans_between(kept_end_ns_, to_ns(first_kept.time));
}

/// Before the scan block at hand.
void Sealer::declare_jump(std::int64_t scans, std::int64_t time_ns) noexcept {
  // Of a device that gave nothing before no index can tell whether it was there.
  const bool was_gone = at(head_).after_absence || sealed_index_ < 0;
  GapBlock jump{.header = header(next_scan_, scans, time_ns),
                .cause = was_gone ? GapCause::kDeviceGone : jump_cause_};
  counts_.scans_sampled += scans;
  if (gap_ || !write_metas() || !write(jump))
    lose(next_scan_, scans, time_ns, jump.cause);
  else
    counts_.scans_missing += scans;
  next_scan_ += scans;
}

/// Up to the stop, behind all that was kept.
bool Sealer::declare_last_silence() noexcept {
  if (next_scan_ == 0) kept_end_ns_ = to_ns(started_.value_or(*silent_at_end_));
  const std::int64_t scans = scans_between(kept_end_ns_, to_ns(*silent_at_end_));
  GapBlock gap{.header = header(next_scan_, scans, kept_end_ns_), .cause = GapCause::kDeviceGone};
  if (scans > 0 && !write(gap)) return false;
  counts_.scans_sampled += scans;
  counts_.scans_missing += scans;
  next_scan_ += scans;
  if (scans > 0) kept_end_ns_ = to_ns(*silent_at_end_);
  silent_at_end_.reset();
  return true;
}

void Sealer::lose(std::int64_t first_scan, std::int64_t scans, std::int64_t time_ns,
                  GapCause cause) noexcept {
  if (planted(PlantedFault::kSilentRingFull)) return;
  if (!gap_) {
    gap_.emplace();
    gap_->cause = cause;
  }
  if (gap_->header.scans == 0) gap_->header = header(first_scan, 0, time_ns);
  gap_->header.scans += scans;
  counts_.scans_missing += scans;
}

bool Sealer::close_gap() noexcept {
  GapBlock gap = *gap_;
  if (planted(PlantedFault::kGapOffByOne) && gap.header.scans > 0) --gap.header.scans;
  if (!write(gap)) return false;
  gap_.reset();
  after_gap_ = true;
  scan_block_.quality |= kQualityAfterGap;
  return true;
}

}  // namespace roadbalance
