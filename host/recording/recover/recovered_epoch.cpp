#include "host/recording/recover/recovered_epoch.hpp"

#include <algorithm>

#include "common/bus/codec.hpp"

namespace roadbalance {

void RecoveredEpoch::declared(const SealedBlock& gap, std::int64_t timestamp_us) {
  declared_.emplace(gap.header.sequence, Timed{gap, timestamp_us});
}

// A declared gap bears the number of its last block; its first scan gives its begin.
GapCause RecoveredEpoch::cause_of_hole(std::int64_t first, std::int64_t last) const {
  const auto known = declared_.lower_bound(first);
  if (known == declared_.end() || !stands_for_lost_blocks(decode_gap(known->second.block).cause))
    return GapCause::kLostInRecord;
  const bool overlaps = known->first <= last || known->second.block.header.first_scan <= next_scan_;
  return overlaps ? decode_gap(known->second.block).cause : GapCause::kLostInRecord;
}

void RecoveredEpoch::write_gap(std::int64_t through, std::int64_t next_scan, GapCause cause,
                               const BlockHeader* behind, std::int64_t timestamp_us, const Write& write) {
  GapBlock gap{.header = last_, .cause = cause};
  gap.header.sequence = through;
  gap.header.first_scan = next_scan_;
  gap.header.time_ns = scan_line_.time_ns(next_scan_, behind).value_or(last_.time_ns);
  gap.header.scans = std::max<std::int64_t>(next_scan - next_scan_, 0);
  SealedBlock sealed;
  seal(gap, sealed);
  write(sealed, timestamp_us);
  last_sequence_ = through;
  next_scan_ = std::max(next_scan_, next_scan);
}

void RecoveredEpoch::write_block(const Timed& timed, const Write& write) {
  write(timed.block, timed.timestamp_us);
  last_ = timed.block.header;
  last_sequence_ = last_.sequence;
  scan_line_.take(timed.block.kind, last_);
  if (timed.block.kind == BlockKind::kScan || timed.block.kind == BlockKind::kGap)
    next_scan_ = last_.first_scan + last_.scans;
  ended_ = ended_ || timed.block.kind == BlockKind::kEnd;
}

// Only the total length of several holes without scans between them is known: the last one gets it.
void RecoveredEpoch::write_waiting(std::int64_t next_scan, const Write& write) {
  auto last_hole = waiting_.end();
  std::int64_t before = last_sequence_;
  const bool is_known = !waiting_.empty() && ScanLine::carries_scan(waiting_.back().block.kind);
  const BlockHeader* const behind = is_known ? &waiting_.back().block.header : nullptr;
  for (auto timed = waiting_.begin(); timed != waiting_.end(); ++timed) {
    if (timed->block.header.sequence > before + 1) last_hole = timed;
    before = timed->block.header.sequence;
  }
  for (auto timed = waiting_.begin(); timed != waiting_.end(); ++timed) {
    const std::int64_t sequence = timed->block.header.sequence;
    if (last_.node == 0) last_ = {.node = timed->block.header.node, .epoch = timed->block.header.epoch};
    if (sequence > last_sequence_ + 1)
      write_gap(sequence - 1, timed == last_hole ? next_scan : next_scan_,
                cause_of_hole(last_sequence_ + 1, sequence - 1), behind, timed->timestamp_us, write);
    write_block(*timed, write);
  }
  waiting_.clear();
}

void RecoveredEpoch::put(const SealedBlock& block, std::int64_t timestamp_us, const Write& write) {
  const bool follows = block.header.sequence == last_put_ + 1;
  last_put_ = block.header.sequence;
  if (follows && waiting_.empty()) return write_block({block, timestamp_us}, write);
  waiting_.push_back({block, timestamp_us});
  if (ScanLine::carries_scan(block.kind)) write_waiting(block.header.first_scan, write);
}

void RecoveredEpoch::finish(const Write& write) {
  write_waiting(next_scan_, write);
  if (ended_) return;
  for (const auto& [sequence, timed] : declared_) {
    const BlockHeader& header = timed.block.header;
    const bool is_crash = decode_gap(timed.block).cause == GapCause::kNodeCrash;
    if (last_.node == 0) last_ = {.node = header.node, .epoch = header.epoch};
    if (!is_crash && sequence > last_sequence_)
      write_gap(sequence, header.first_scan + header.scans, GapCause::kLostAtNode, &header,
                timed.timestamp_us, write);
    if (is_crash) {
      write_gap(last_sequence_ + 1, next_scan_, GapCause::kNodeCrash, &header, timed.timestamp_us, write);
      return;
    }
  }
}

}  // namespace roadbalance
