#include "firmware/pack.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace roadbalance {
namespace {

// Signals reach the record soon after their scans, and edges where so many are worth a block of 1.3 kB: 4
// bytes each, with all that the record puts around it.
constexpr std::int64_t kSoon_ns = 200'000'000, kLongestEdgeBlock_ns = 1'000'000'000;
constexpr std::int32_t kEdgesThatPay = 350;

std::size_t waiting_capacity(double rate_hz) {
  // The longest wait, a block beside it and the lag of edges behind scans.
  return static_cast<std::size_t>(std::ceil(0.25 * rate_hz)) + 4 * kScansPerBlock;
}

}  // namespace

Sealer::Sealer(const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch, BlockSink& sink,
               PreviewSlot* preview, GapCause jump)
    : node_(node.id),
      epoch_(epoch),
      period_ps_(std::llround(1e12 / node.rate_hz)),
      jump_cause_(jump),
      loop_back_(node.wiring.loop_back),
      sink_(sink),
      preview_(preview),
      reference_(vehicle, node),
      meta_(split_text(MetaKind::kVehicleToml, vehicle.text)),
      waiting_(waiting_capacity(node.rate_hz)) {}

void Sealer::start() noexcept {
  if (started()) return;
  keep_from_ = tail_;
  started_ = silence_.asked();
  static_cast<void>(write_metas());  // a sink too small is asked again before the first scan block
}

void Sealer::stop() noexcept {
  start();
  if (keep_to_ != kNever) return;
  keep_to_ = tail_;
  if (silence_.is_long()) silent_at_end_ = silence_.asked();
}

bool Sealer::write_metas() noexcept {
  for (; metas_written_ < meta_.size(); ++metas_written_) {
    MetaBlock& part = meta_[metas_written_];
    part.header = header(0, 0, to_ns(now_));
    if (!write(part)) return false;
  }
  return true;
}

std::size_t Sealer::most_blocks(std::size_t scans, std::size_t edges, std::size_t signals) const noexcept {
  // Index jumps make more, but a device that waits for its reader loses nothing.
  constexpr std::size_t kOthers = 8;
  const std::size_t all_scans = waiting_.size() + scans;
  const auto all_ns = static_cast<std::int64_t>(all_scans) * (period_ps_ / 1000);
  const std::int64_t by_age = all_ns / kLongestEdgeBlock_ns + all_ns / kSoon_ns;
  return meta_.size() + all_scans / kScansPerBlock + edges / (kEdgeBytesPerBlock / kMostEdgeCodeBytes) +
         signals / kSamplesPerBlock + static_cast<std::size_t>(by_age) + kOthers;
}

void Sealer::push(const Scan& scan) noexcept {
  if (scan.index < next_index_ || scan.index >= kIndexLimit) {
    ++counts_.scans_refused;
    return;
  }
  if (next_index_ >= 0 && scan.index != next_index_) ++jumps_;
  next_index_ = scan.index + 1;
  waiting_[static_cast<std::size_t>(tail_) % waiting_.size()] = scan;
  ++tail_;
  now_ = scan.time;
}

void Sealer::add(std::span<const Scan> scans, std::span<const Edge> edges, bool more_edges) noexcept {
  const NodeTime edges_end = more_edges && !edges.empty() ? edges.back().time : NodeTime::max();
  // Scan by scan with the edges before it, so that the result does not depend on the size of a read.
  auto edge = edges.begin();
  const auto take = [&](const Edge& e) {
    reference_.add(e);
    if (started() && keep_to_ == kNever) record(e);
  };
  for (const Scan& scan : scans) {
    for (; edge != edges.end() && edge->time <= scan.time; ++edge) take(*edge);
    push(scan);
    while (seal_next(std::min(scan.time, edges_end), false)) {
    }
    if (tail_ - head_ == static_cast<std::int64_t>(waiting_.size())) seal_next(scan.time, true);
  }
  for (; edge != edges.end(); ++edge) take(*edge);
}

void Sealer::add(std::span<const SignalSample> signals) noexcept {
  reference_.add(signals);
  if (!started() || keep_to_ != kNever) return;
  for (const SignalSample& sample : signals)
    if (!place(sample, signal_block_)) lose_beside(sample.time);
}

void Sealer::asked(NodeTime now) noexcept {
  silence_.asked(now, std::exchange(asked_tail_, tail_) != tail_);
}

void Sealer::device_ended() noexcept {
  if (started()) stop();
  while (seal_next(now_, true)) {
  }
}

Sealer::Run Sealer::next_run() const noexcept {
  Run run{static_cast<int>(std::min<std::int64_t>(kScansPerBlock, tail_ - head_)), false};
  for (const std::int64_t border : {keep_from_, keep_to_})
    if (head_ < border && border <= head_ + run.scans) run = {static_cast<int>(border - head_), true};
  if (jumps_ > 0)
    for (int i = 1; i < run.scans; ++i)
      if (at(head_ + i).index != at(head_ + i - 1).index + 1) run = {i, true};
  run.whole = run.whole || run.scans == kScansPerBlock;
  return run;
}

bool Sealer::seal_next(NodeTime edges_through, bool at_once) noexcept {
  const Run run = next_run();
  if (run.scans == 0 || !(run.whole || at_once)) return false;
  const NodeTime first = at(head_).time, last = at(head_ + run.scans - 1).time;
  const bool waited = now_ - last >= NodeClock::duration(kLongestWait_ns);
  // What a wheel's teeth have not told is not asked for anew at every scan, nor are the other wheel's angles.
  if (!waited && !at_once && tail_ < next_attempt_) return false;
  const bool complete = at_once || edges_through >= reference_.complete_at(last);
  const bool located = complete && reference_.locate(first, run.scans);
  if (!located) {
    if (complete) next_attempt_ = tail_ + kScansPerBlock;
    if (!waited && !at_once) return false;
    if (!complete) static_cast<void>(reference_.locate(first, run.scans));
  }
  const bool after_jump = sealed_index_ < 0 || at(head_).index != sealed_index_;
  if (after_jump && sealed_index_ >= 0) --jumps_;
  build(run.scans);
  scan_block_.quality |=
      reference_.fill(std::span(scan_block_.counts).first(static_cast<std::size_t>(run.scans)), after_jump);
  if (loop_back_)  // what came back through the real filter takes the place of what was computed
    for (int i = 0; i < run.scans; ++i)
      std::copy_n(at(head_ + i).references.begin(), kReferences,
                  scan_block_.counts[static_cast<std::size_t>(i)].begin() + kAccelerations);
  if (head_ >= keep_from_ && head_ < keep_to_)
    keep_block(after_jump);
  else
    preview_block();
  sealed_index_ = at(head_ + run.scans - 1).index + 1;
  head_ += run.scans;
  return true;
}

void Sealer::build(int scans) noexcept {
  scan_block_.header = header(0, scans, to_ns(at(head_).time));
  scan_block_.period_ps = period_ps_;
  scan_block_.overload = 0;
  for (int i = 0; i < kScansPerBlock; ++i) {
    auto& row = scan_block_.counts[static_cast<std::size_t>(i)];
    if (i >= scans) {
      row.fill(0);
      continue;
    }
    const Scan& scan = at(head_ + i);
    std::memcpy(row.data(), scan.counts.data(), sizeof scan.counts);  // of known size: no call
    scan_block_.overload |= static_cast<std::int32_t>(scan.overload);
  }
  scan_block_.quality = scan_block_.overload ? kQualityOverload : 0;
}

void Sealer::preview_block() noexcept {
  if (!preview_) return;
  scan_block_.header.sequence = 0;
  scan_block_.header.first_scan = at(head_).index;
  seal(scan_block_, preview_->writable());
  preview_->publish();
}

void Sealer::keep_block(bool after_jump) noexcept {
  if (!first_index_) count_from(at(head_));
  const std::int64_t first = at(head_).index - *first_index_;
  const std::int64_t scans = scan_block_.header.scans;
  counts_.scans_sampled += scans;
  const std::int64_t end_ns = to_ns(at(head_ + scans - 1).time) + period_ps_ / 1000;
  const std::int64_t time_ns = std::exchange(kept_end_ns_, end_ns);
  if (first > next_scan_) declare_jump(first - next_scan_, time_ns);
  scan_block_.header.first_scan = first;
  if (after_jump && first > 0) after_gap_ = true;
  if (after_gap_) scan_block_.quality |= kQualityAfterGap;
  if (!write_what_comes_before() || !write(scan_block_)) {
    lose(first, scans, scan_block_.header.time_ns, GapCause::kRingFull);
    after_gap_ = true;
  } else {
    after_gap_ = false;
    if (reference_.lacks_angle(scan_block_.quality)) ++counts_.unreferenced_blocks;
  }
  next_scan_ = first + scans;
  const auto put_if_old = [&](auto& block, std::int64_t longest_ns) {
    if (to_ns(now_) - block.header.time_ns > longest_ns) static_cast<void>(write_beside(block));
  };
  put_if_old(edge_block_, edge_block_.edges < kEdgesThatPay ? kLongestEdgeBlock_ns : kSoon_ns);
  put_if_old(signal_block_, kSoon_ns);
}

/// An edge or a sample for which neither its block nor the sink has room.
void Sealer::lose_beside(NodeTime time) noexcept {
  lose(next_scan_, 0, next_scan_ > 0 ? kept_end_ns_ : to_ns(now_), GapCause::kRingFull);
  // A stamp that runs far ahead would keep the gap open for as long.
  lost_through_ = std::max(lost_through_, std::min(time, now_ + NodeClock::duration(kLongestEdgeBlock_ns)));
}

/// Of the scan block at hand.  False: it belongs to the gap, which covers a scan and what was lost beside.
bool Sealer::write_what_comes_before() noexcept {
  if (!write_metas()) return false;
  if (!gap_) return true;
  if (gap_->header.scans == 0 || at(head_).time <= lost_through_) return false;
  return write_beside(edge_block_) && write_beside(signal_block_) && close_gap();
}

void Sealer::record(const Edge& edge) noexcept {
  if (dropped_.pass(edge, [this](const Edge& e) { return place(e, edge_block_); })) return;
  static_cast<void>(dropped_.drop(edge.line));
  lose_beside(edge.time);
}

template <typename Item, typename Block>
bool Sealer::place(const Item& item, Block& block) noexcept {
  return block.add(item) || (write_beside(block) && block.add(item));
}

/// Edges or signals so far, which stand beside the scans that were sealed last and before those of a gap.
template <typename Block>
bool Sealer::write_beside(Block& block) noexcept {
  if (block.empty()) return true;
  block.header = header(gap_ ? gap_->header.first_scan : next_scan_, 0, block.header.time_ns);
  if (!write_metas() || !write(block)) return false;
  block = Block{};
  return true;
}

bool Sealer::finish() noexcept {
  if (ended_) return true;
  if (head_ < keep_to_ || keep_to_ == kNever || !write_metas()) return false;
  if (!write_beside(edge_block_) || !write_beside(signal_block_) || (gap_ && !close_gap())) return false;
  if (silent_at_end_ && !declare_last_silence()) return false;
  EndBlock end{.header = header(next_scan_, 0, next_scan_ > 0 ? kept_end_ns_ : to_ns(now_)),
               .blocks = next_sequence_,
               .scans_sealed = counts_.scans_sampled - counts_.scans_missing,
               .scans_missing = counts_.scans_missing,
               .blocks_crc32c = sum_.crc32c()};
  ended_ = write(end);
  return ended_;
}

}  // namespace roadbalance
