#include <algorithm>
#include <span>

#include "hil_tests/deterministic/node_program.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kDeviceHolds = 256;  // scans; older ones are lost while nobody reads
constexpr std::int64_t kScansPerEdge = 32;

// At an instant of its own between the scan and the one before.
Edge edge_before(const Scan& scan) {
  const std::int64_t number = scan.index / kScansPerEdge;
  return {.time = scan.time - NodeClock::duration(number * 7919 % 20'000),
          .line = static_cast<std::uint8_t>(number % kEncoderLines),
          .kind = number % 97 == 0 ? EdgeKind::kZeroMark : EdgeKind::kTooth};
}

}  // namespace

void NodeMachine::read(std::int64_t now_ns) {
  Program& p = *program_;
  const double since_s = static_cast<double>(now_ns - p.started_ns) * 1e-9;
  const auto end = static_cast<std::int64_t>(since_s * scenario_.rate_hz);
  p.next_index = std::max(p.next_index, end - kDeviceHolds);
  const auto count = static_cast<std::size_t>(end - p.next_index);
  if (p.sealer.started() && p.first_index < 0 && count > 0) p.first_index = p.next_index;
  const std::int64_t first = p.next_index - std::max<std::int64_t>(0, p.first_index);
  p.samples.fill(first, std::span(counts_).first(count));
  edges_.clear();
  for (std::size_t k = 0; k < count; ++k) {
    Scan& scan = scans_[k];
    scan.index = p.next_index++;
    const auto taken_ns =
        static_cast<std::int64_t>(1e9 / scenario_.rate_hz * static_cast<double>(scan.index));
    scan.time = node_time_from_ns(clock_ns(p.started_ns + taken_ns));
    scan.counts = counts_[k];
    if (scan.index % kScansPerEdge == 0) edges_.push_back(edge_before(scan));
  }
  give_what_stands_beside(count);
  p.sealer.add(std::span(scans_).first(count), edges_, false);
  if (p.first_index >= 0 && !p.link.stop.load()) p.truth.scans = p.next_index - p.first_index;
}

// Edges of both lines, and a sample a read: with them blocks without scans, which nothing tells of but their
// numbers.
void NodeMachine::give_what_stands_beside(std::size_t scans) {
  Program& p = *program_;
  if (scans == 0) return;
  const Scan& last = scans_[scans - 1];
  const SignalSample sample{.time = last.time, .signal = 3, .value = static_cast<double>(last.index)};
  if (p.sealer.started() && !p.link.stop.load()) {
    for (const Edge& edge : edges_) p.beside.given(edge);
    p.beside.given(sample);
  }
  p.sealer.add({&sample, 1});
}

// The body of firmware/acquire.cpp's loop, one read of a device that does not wait.
std::int64_t NodeMachine::device(std::int64_t now_ns) {
  constexpr std::int64_t kScansPerVisit = 20;
  const auto more_ns = static_cast<std::int64_t>(static_cast<double>(kScansPerVisit) / scenario_.rate_hz *
                                                 1e9 * random_.between(0.5, 1.5));
  if (!runs() || program_->stopped) return now_ns + more_ns;
  Program& p = *program_;
  const std::int64_t before = p.backlog.base();
  p.sink.now_ns = now_ns;
  p.sealer.asked(node_time_from_ns(clock_ns(now_ns)));
  if (p.link.start.load() && !p.sealer.started()) {
    p.sealer.start();
    p.truth.started_by = p.uplink.owner();
  }
  if (p.link.stop.load()) {
    p.sealer.stop();
    p.stopped = p.sealer.finish();
  }
  if (!p.stopped) read(now_ns);
  const NodeState state = p.sealer.started() ? NodeState::kStarted : NodeState::kPreview;
  tell(p.sealer, p.stopped ? NodeState::kEnded : state, p.link);
  watch_freed({}, {}, before);
  return now_ns + more_ns;
}

}  // namespace roadbalance::test
