#include "firmware/acquire.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>

#include "common/types/clock_pair.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

namespace {

/// How long to leave a device alone that waits for us, or a sink that is full after the end.
constexpr auto kPatience = std::chrono::microseconds(200);
/// How long the last scans may wait, after a stop, for what their references need: a silent device never
/// brings it.
constexpr auto kLastReferences = std::chrono::seconds(1);

void count_turn(AcquireLink& link) noexcept {
  link.acquire_turns.fetch_add(1, std::memory_order_relaxed);
}

/// Until the end is written; a sink that stays full is asked again and again.
void finish(std::stop_token stop, BlockPacker& packer, AcquireLink& link) noexcept {
  while (!packer.finish() && !stop.stop_requested()) {
    count_turn(link);
    std::this_thread::sleep_for(kPatience);
  }
}

// An instant by the device's clock, before which it is not to give anything.
NodeTime by_device(const FrontEnd& front_end, WallTime at) {
  if (front_end.waits() || at == AcquireLink::kAtOnce) return NodeTime::min();
  const MachineTime instant(at.time_since_epoch() + machine_minus(CLOCK_MONOTONIC));
  return std::max(front_end.begins(), front_end.node_time(instant));
}

void obey(const AcquireLink& link, const FrontEnd& front_end, BlockPacker& packer) {
  const WallTime start_at = link.start_at.load(std::memory_order_acquire);
  if (start_at != AcquireLink::kNotAsked && !packer.started()) packer.start(by_device(front_end, start_at));
  const WallTime stop_at = link.stop_at.load(std::memory_order_acquire);
  if (stop_at != AcquireLink::kNotAsked) packer.stop(by_device(front_end, stop_at));
}

void ask(const FrontEnd& front_end, BlockPacker& packer) {
  const NodeTime now = front_end.node_time(MachineClock::now());
  if (now >= front_end.begins()) packer.asked(now);
}

}  // namespace

void report_progress(const BlockPacker& packer, NodeState state, AcquireLink& link) noexcept {
  constexpr auto kRelaxed = std::memory_order_relaxed;
  link.time_ns.store(to_ns(packer.time()), kRelaxed);
  link.scans_sampled.store(packer.counts().scans_sampled, kRelaxed);
  link.scans_missing.store(packer.counts().scans_missing, kRelaxed);
  link.unreferenced_blocks.store(packer.counts().unreferenced_blocks, kRelaxed);
  link.scans_refused.store(packer.counts().scans_refused, kRelaxed);
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    const EncoderFaults faults = packer.encoder_faults(static_cast<int>(line));
    const auto count_up = [&encoder = link.encoder[line]](DeviceCounter counter, std::int64_t by_now) {
      encoder.count(counter, by_now - encoder.of(counter));
    };
    count_up(DeviceCounter::kFaultyTurns, faults.turns);
    count_up(DeviceCounter::kCountBroken, faults.breaks);
    count_up(DeviceCounter::kMarksElsewhere, faults.marks_elsewhere);
    for (std::size_t k = 0; k < 2; ++k) link.mark_counts[2 * line + k].store(faults.mark_counts[k], kRelaxed);
  }
  link.state.store(state, std::memory_order_release);
}

void acquire(std::stop_token stop, FrontEnd& front_end, BlockPacker& packer, BlockSink& sink,
             AcquireLink& link) noexcept {
  std::array<Scan, kScansPerRead> scans;
  std::array<Edge, kEdgesPerRead> edges;
  std::array<SignalSample, kSignalsPerRead> signals;
  const std::size_t most = packer.most_blocks(scans.size(), edges.size(), signals.size());
  NodeState last = NodeState::kEnded;
  AbsenceCause cause = AbsenceCause::kProgramEnded;
  std::optional<WallTime> stops_at;
  while (!stop.stop_requested()) {
    count_turn(link);
    if (!front_end.waits()) ask(front_end, packer);
    obey(link, front_end, packer);
    const WallTime stop_at = link.stop_at.load(std::memory_order_acquire);
    if (stop_at != AcquireLink::kNotAsked) {
      if (!stops_at) stops_at = std::max(stop_at, WallClock::now());
      if (!front_end.waits() && WallClock::now() - *stops_at > kLastReferences) packer.device_ended();
      if (packer.finish()) {
        cause = AbsenceCause::kStopped;
        break;
      }
    }
    if (front_end.waits() && (!packer.started() || sink.room() < most)) {
      std::this_thread::sleep_for(kPatience);
      continue;
    }
    const Read read = front_end.read(scans, edges, signals);
    obey(link, front_end, packer);  // scans of behind an instant may come with those of before
    packer.add(std::span(signals).first(read.signals));
    packer.add(std::span(scans).first(read.scans), std::span(edges).first(read.edges),
               read.edges == edges.size());
    // One that is to begin in a moment is no idle node any more.
    const bool is_asked = link.start_at.load(std::memory_order_relaxed) != AcquireLink::kNotAsked;
    report_progress(packer, is_asked ? NodeState::kStarted : NodeState::kPreview, link);
    if (read.status == ReadStatus::kOk) continue;
    link.device_ended = true;
    const bool has_failed = read.status == ReadStatus::kFailed;
    if (has_failed) last = NodeState::kFailed;
    cause = has_failed ? AbsenceCause::kDeviceFailed : AbsenceCause::kSourceOver;
    break;
  }
  packer.device_ended();
  if (packer.started()) {
    report_progress(packer, NodeState::kStarted, link);
    finish(stop, packer, link);
  }
  link.end_cause = cause;
  report_progress(packer, last, link);
}

}  // namespace roadbalance
