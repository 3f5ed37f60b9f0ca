#include "firmware/backends/gpio/edge_maker.hpp"

#include <algorithm>
#include <utility>

namespace roadbalance {

EdgeMaker::EdgeMaker(std::vector<GpioInput> inputs, DeviceReport& report)
    : inputs_(std::move(inputs)), report_(report) {
  for (const GpioInput& input : inputs_)
    if (input.track == GpioTrack::kDirection) has_direction_[input.line] = true;
}

void EdgeMaker::start(std::uint8_t line, std::optional<bool> tooth, std::optional<bool> direction) noexcept {
  quadrature_[line].start(tooth, direction);
}

// The two clocks are compared anew at every reading, to a microsecond: edges nearer together may come out of
// order, and a merging reader takes none that is not later.
Edge EdgeMaker::edge(std::uint8_t line, EdgeKind kind, NodeTime time) noexcept {
  last_ = std::max(time, last_ + NodeClock::duration(1));
  return {.time = last_, .line = line, .kind = kind};
}

Edge EdgeMaker::lost(std::uint8_t line, NodeTime time) noexcept {
  quadrature_[line].forget();
  return edge(line, EdgeKind::kLost, time);
}

std::size_t EdgeMaker::take(const InputEvent& event, std::span<Edge, kMost> edges) noexcept {
  const GpioInput& input = inputs_[event.input];
  const NodeTime time = node_time_from_ns(event.monotonic_ns + event.machine_minus_monotonic_ns);
  std::size_t count = 0;
  const auto put = [&](EdgeKind kind) { edges[count++] = edge(input.line, kind, time); };
  const bool rising = event.kind == InputEvent::kRising;
  if (event.kind == InputEvent::kLost) {
    report_.count(DeviceCounter::kEdgesLost);
    edges[count++] = lost(input.line, time);
  } else if (input.track == GpioTrack::kZeroMark) {
    if (rising) put(EdgeKind::kZeroMark);
  } else if (!has_direction(input.line)) {
    if (rising) put(EdgeKind::kTooth);
  } else {
    const auto track = input.track == GpioTrack::kTooth ? Quadrature::kA : Quadrature::kB;
    const Quadrature::Step step = quadrature_[input.line].take(track, rising);
    if (step.lost) {
      report_.count(DeviceCounter::kEdgesLost);
      put(EdgeKind::kLost);
    }
    if (step.tooth) put(*step.tooth);
  }
  return count;
}

}  // namespace roadbalance
