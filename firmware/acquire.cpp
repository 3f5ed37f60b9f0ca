#include "firmware/acquire.hpp"

#include <chrono>
#include <optional>
#include <thread>

#include "common/clock/clocks.hpp"

namespace roadbalance {

namespace {

/// How long to leave a device alone that waits for us, or a sink that is full after the end.
constexpr auto kPatience = std::chrono::microseconds(200);
/// Told to stop, how long the last scans may wait for what their references need: a silent device brings it
/// never.
constexpr auto kLastReferences = std::chrono::seconds(1);

void count_turn(AcquireLink& link) noexcept {
  link.acquire_turns.fetch_add(1, std::memory_order_relaxed);
}

/// Until the end is written; a sink that stays full is asked again and again.
void finish(std::stop_token stop, Sealer& sealer, AcquireLink& link) noexcept {
  while (!sealer.finish() && !stop.stop_requested()) {
    count_turn(link);
    std::this_thread::sleep_for(kPatience);
  }
}

void ask(const FrontEnd& front_end, Sealer& sealer) {
  const NodeTime now = front_end.node_time(MachineClock::now());
  if (now >= front_end.begins()) sealer.asked(now);
}

}  // namespace

void tell(const Sealer& sealer, NodeState state, AcquireLink& link) noexcept {
  constexpr auto kRelaxed = std::memory_order_relaxed;
  link.time_ns.store(to_ns(sealer.time()), kRelaxed);
  link.scans_sampled.store(sealer.counts().scans_sampled, kRelaxed);
  link.scans_missing.store(sealer.counts().scans_missing, kRelaxed);
  link.unreferenced_blocks.store(sealer.counts().unreferenced_blocks, kRelaxed);
  link.scans_refused.store(sealer.counts().scans_refused, kRelaxed);
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    const EncoderFaults faults = sealer.encoder_faults(static_cast<int>(line));
    const auto say = [&encoder = link.encoder[line]](DeviceCounter counter, std::int64_t by_now) {
      encoder.count(counter, by_now - encoder.of(counter));
    };
    say(DeviceCounter::kFaultyTurns, faults.turns);
    say(DeviceCounter::kCountBroken, faults.breaks);
    say(DeviceCounter::kMarksElsewhere, faults.marks_elsewhere);
  }
  link.state.store(state, std::memory_order_release);
}

void acquire(std::stop_token stop, FrontEnd& front_end, Sealer& sealer, BlockSink& sink,
             AcquireLink& link) noexcept {
  std::array<Scan, kScansPerRead> scans;
  std::array<Edge, kEdgesPerRead> edges;
  std::array<SignalSample, kSignalsPerRead> signals;
  const std::size_t most = sealer.most_blocks(scans.size(), edges.size(), signals.size());
  NodeState last = NodeState::kEnded;
  std::optional<WallTime> told_to_stop;
  while (!stop.stop_requested()) {
    count_turn(link);
    if (!front_end.waits()) ask(front_end, sealer);
    if (link.start.load(std::memory_order_acquire)) sealer.start();
    if (link.stop.load(std::memory_order_acquire)) {
      sealer.stop();
      if (!told_to_stop) told_to_stop = WallClock::now();
      if (!front_end.waits() && WallClock::now() - *told_to_stop > kLastReferences) sealer.device_ended();
      if (sealer.finish()) break;
    }
    if (front_end.waits() && (!sealer.started() || sink.room() < most)) {
      std::this_thread::sleep_for(kPatience);
      continue;
    }
    const Read read = front_end.read(scans, edges, signals);
    sealer.add(std::span(signals).first(read.signals));
    sealer.add(std::span(scans).first(read.scans), std::span(edges).first(read.edges),
               read.edges == edges.size());
    tell(sealer, sealer.started() ? NodeState::kStarted : NodeState::kPreview, link);
    if (read.status == ReadStatus::kOk) continue;
    link.device_ended = true;
    if (read.status == ReadStatus::kFailed) last = NodeState::kFailed;
    break;
  }
  sealer.device_ended();
  if (sealer.started()) {
    tell(sealer, NodeState::kStarted, link);
    finish(stop, sealer, link);
  }
  tell(sealer, last, link);
}

}  // namespace roadbalance
