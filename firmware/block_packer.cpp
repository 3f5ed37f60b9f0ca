#include "firmware/block_packer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace roadbalance {

BlockPacker::BlockPacker(const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch,
                         BlockSink& sink, PreviewSlot* preview, GapCause jump)
    : period_ps_(std::llround(1e12 / node.rate_hz)),
      loop_back_(node.wiring.loop_back),
      preview_(preview),
      reference_(vehicle, node),
      writer_(node.id, epoch, vehicle.text, sink),
      waiting_(node.rate_hz),
      tiling_(writer_, period_ps_, jump),
      beside_(writer_, tiling_) {}

void BlockPacker::start(NodeTime from) noexcept {
  if (started()) return;
  start_at_ = from;
  if (from > time()) return;
  begin(from != NodeTime::min() && waiting_.end() > 0);
  keep_from_ = waiting_.end();
}

void BlockPacker::begin(bool is_late) noexcept {
  started_ = true;
  tiling_.start(start_at_, is_late);
  static_cast<void>(
      writer_.write_description(time()));  // a sink too small is asked again before the first scan block
}

void BlockPacker::stop(NodeTime to) noexcept {
  if (start_at_ == NodeTime::max()) start(to);  // an epoch without scans
  if (keep_to_ != kNever) return;
  stop_at_ = to;
  if (to <= time()) end();
}

void BlockPacker::end() noexcept {
  if (!started()) begin(false);
  keep_to_ = waiting_.end();
  keep_from_ = std::min(keep_from_, keep_to_);
  tiling_.stop(stop_at_);
}

std::size_t BlockPacker::most_blocks(std::size_t scans, std::size_t edges,
                                     std::size_t signals) const noexcept {
  // Index jumps make more, but a device that waits for its reader loses nothing.
  constexpr std::size_t kOthers = 8;
  const std::size_t all_scans = waiting_.capacity() + scans;
  const auto all_ns = static_cast<std::int64_t>(all_scans) * (period_ps_ / 1000);
  return writer_.description_blocks() + all_scans / kScansPerBlock +
         SideBlocks::most_blocks(edges, signals, all_ns) + kOthers;
}

void BlockPacker::add(std::span<const Scan> scans, std::span<const Edge> edges, bool more_edges) noexcept {
  const NodeTime edges_end = more_edges && !edges.empty() ? edges.back().time : NodeTime::max();
  // Scan by scan with the edges before it, so that the result does not depend on the size of a read.
  auto edge = edges.begin();
  const auto take = [&](const Edge& e) {
    reference_.add(e);
    if (keeps_beside(e.time)) beside_.add(e, time());
  };
  for (const Scan& scan : scans) {
    for (; edge != edges.end() && edge->time <= scan.time; ++edge) take(*edge);
    if (keep_from_ == kNever && scan.time >= start_at_) {
      if (!started()) begin(false);
      keep_from_ = waiting_.end();
    }
    if (keep_to_ == kNever && scan.time >= stop_at_) end();
    if (!waiting_.push(scan)) ++scans_refused_;
    while (seal_next(std::min(scan.time, edges_end), false)) {
    }
    if (waiting_.is_full()) seal_next(scan.time, true);
  }
  for (; edge != edges.end(); ++edge) take(*edge);
}

void BlockPacker::add(std::span<const SignalSample> signals) noexcept {
  reference_.add(signals);
  for (const SignalSample& sample : signals)
    if (keeps_beside(sample.time)) beside_.add(sample, time());
}

// It may be stamped behind scans that are still to come.
bool BlockPacker::keeps_beside(NodeTime stamped) noexcept {
  if (stamped < start_at_ || keep_to_ != kNever || stamped >= stop_at_) return false;
  if (!started()) begin(false);
  return true;
}

void BlockPacker::asked(NodeTime now) noexcept {
  tiling_.asked(now, waiting_.end());
  if (!tiling_.is_silent()) return;
  if (!started() && now >= start_at_) begin(false);
  if (keep_to_ == kNever && now >= stop_at_) end();
}

void BlockPacker::device_ended() noexcept {
  if (start_at_ != NodeTime::max()) stop();
  while (seal_next(time(), true)) {
  }
}

bool BlockPacker::seal_next(NodeTime edges_through, bool at_once) noexcept {
  const WaitingScans::Run run = waiting_.next_run({keep_from_, keep_to_});
  if (run.scans == 0 || !(run.whole || at_once)) return false;
  const std::int64_t head = waiting_.begin();
  const NodeTime first = waiting_.front().time, last = waiting_.at(head + run.scans - 1).time;
  const bool waited = time() - last >= NodeClock::duration(kLongestWait_ns);
  // Angles that a wheel's teeth did not give are not asked for anew at every scan, nor are the other wheel's.
  if (!waited && !at_once && waiting_.end() < next_attempt_) return false;
  const bool complete = at_once || edges_through >= reference_.complete_at(last);
  const bool located = complete && reference_.locate(first, run.scans);
  if (!located) {
    if (complete) next_attempt_ = waiting_.end() + kScansPerBlock;
    if (!waited && !at_once) return false;
    if (!complete) static_cast<void>(reference_.locate(first, run.scans));
  }
  const bool after_jump = waiting_.after_jump();
  build(run.scans);
  scan_block_.quality |=
      reference_.fill(std::span(scan_block_.counts).first(static_cast<std::size_t>(run.scans)), after_jump);
  if (loop_back_)  // what came back through the real filter takes the place of what was computed
    for (int i = 0; i < run.scans; ++i)
      std::copy_n(waiting_.at(head + i).references.begin(), kReferences,
                  scan_block_.counts[static_cast<std::size_t>(i)].begin() + kAccelerations);
  if (head >= keep_from_ && head < keep_to_)
    keep_block();
  else
    preview_block();
  waiting_.take(run.scans);
  return true;
}

void BlockPacker::build(int scans) noexcept {
  scan_block_.header = writer_.header(0, scans, to_ns(waiting_.front().time));
  scan_block_.period_ps = period_ps_;
  scan_block_.overload = 0;
  for (int i = 0; i < kScansPerBlock; ++i) {
    auto& row = scan_block_.counts[static_cast<std::size_t>(i)];
    if (i >= scans) {
      row.fill(0);
      continue;
    }
    const Scan& scan = waiting_.at(waiting_.begin() + i);
    std::memcpy(row.data(), scan.counts.data(), sizeof scan.counts);  // of known size: no call
    scan_block_.overload |= static_cast<std::int32_t>(scan.overload);
  }
  scan_block_.quality = scan_block_.overload ? kQualityOverload : 0;
}

void BlockPacker::preview_block() noexcept {
  if (!preview_) return;
  scan_block_.header.sequence = 0;
  scan_block_.header.first_scan = waiting_.front().index;
  seal(scan_block_, preview_->writable());
  preview_->publish();
}

void BlockPacker::keep_block() noexcept {
  const std::int64_t scans = scan_block_.header.scans;
  const std::int64_t end_ns = to_ns(waiting_.at(waiting_.begin() + scans - 1).time) + period_ps_ / 1000;
  const std::int64_t next = tiling_.next_scan();
  const std::int64_t first = tiling_.keep(waiting_.front(), scans, end_ns, !waiting_.any_taken(), time());
  scan_block_.header.first_scan = first;
  if (first != next) after_gap_ = true;
  if (after_gap_) scan_block_.quality |= kQualityAfterGap;
  if (!write_what_comes_before() || !writer_.write(scan_block_)) {
    tiling_.lose(first, scans, scan_block_.header.time_ns, GapCause::kRingFull);
    after_gap_ = true;
  } else {
    after_gap_ = false;
    if (reference_.lacks_angle(scan_block_.quality)) ++unreferenced_blocks_;
  }
  beside_.write_old(time());
}

/// Before the scan block at hand.  False: it belongs to the gap, which covers a scan and what was lost
/// beside.
bool BlockPacker::write_what_comes_before() noexcept {
  if (!writer_.write_description(time())) return false;
  const GapBlock* const gap = tiling_.gap();
  if (!gap) return true;
  if (gap->header.scans == 0 || waiting_.front().time <= beside_.lost_through()) return false;
  if (!beside_.write_all(time()) || !tiling_.close_gap()) return false;
  after_gap_ = true;
  scan_block_.quality |= kQualityAfterGap;
  return true;
}

bool BlockPacker::finish() noexcept {
  if (ended_) return true;
  if (waiting_.begin() < keep_to_ || keep_to_ == kNever || !writer_.write_description(time())) return false;
  if (!beside_.write_all(time()) || !tiling_.finish()) return false;
  EndBlock end = tiling_.end_block(time());
  ended_ = writer_.write(end);
  return ended_;
}

}  // namespace roadbalance
