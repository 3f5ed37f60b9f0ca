#include "hil_tests/guest/gpio_rig.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/bus/codec.hpp"
#include "common/types/clock_pair.hpp"
#include "firmware/block_packer.hpp"
#include "firmware/ring_sink.hpp"
#include "firmware/test/vehicle.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kLongestWait_ns = 30'000'000'000;

}  // namespace

GpioRig::GpioRig(std::vector<LineConfig> lines, int teeth) : vehicle(one_node_vehicle(2000.0, teeth)) {
  vehicle.node[0].wiring.line = std::move(lines);
  edges.reserve(200'000);  // fresh memory costs guest time
  source = open_gpio({PulseChip::name(), vehicle, vehicle.node[0]},
                     [this](const std::string& text) { warnings += text + '\n'; });
  machine_minus_monotonic_ns = machine_minus(CLOCK_MONOTONIC).count();
}

void GpioRig::take() {
  static std::array<Edge, 4096> some;
  const SideRead read = source->take(some, {});
  for (std::size_t k = 0; k < read.edges; ++k) {
    EXPECT_GT(some[k].time, edges.empty() ? NodeTime::min() : edges.back().time) << "edges come in order";
    const bool is_late = some[k].time < complete_;
    EXPECT_TRUE(!is_late || in_real_time) << "an edge came after it was said that all had come";
    // In real time the kernel's own thread may be late; then a node marks the hole, as MixedFrontEnd does.
    if (is_late) {
      static_cast<void>(dropped_.drop(some[k].line));
      continue;
    }
    EXPECT_TRUE(dropped_.pass(some[k], [this](const Edge& edge) {
      edges.push_back(edge);
      return true;
    }));
  }
  EXPECT_GE(read.complete_until, complete_);
  complete_ = read.complete_until;
}

/// False once that instant has come.
bool GpioRig::take_for_a_moment(std::int64_t end_ns) {
  const timespec pause{0, 5'000'000};
  ::nanosleep(&pause, nullptr);
  take();
  return PulseChip::now_ns() < end_ns;
}

void GpioRig::take_for(std::int64_t duration_ns) {
  for (const std::int64_t end = PulseChip::now_ns() + duration_ns; take_for_a_moment(end);) {
  }
}

void GpioRig::take_until(DeviceCounter counter, std::int64_t times) {
  for (const std::int64_t end = PulseChip::now_ns() + kLongestWait_ns; counted(counter) < times;)
    ASSERT_TRUE(take_for_a_moment(end)) << name_of(counter) << " stays at " << counted(counter);
}

void GpioRig::play(const std::vector<gpio_pulse_step>& steps) {
  chip.play(steps);
  take_for(static_cast<std::int64_t>(steps.back().t_ns) - PulseChip::now_ns());
  const auto played = chip.played();  // all: it waits for a player that is late
  truth.insert(truth.end(), played.begin(), played.end());
  if (played.empty()) return;
  const NodeTime last =
      node_time_from_ns(static_cast<std::int64_t>(played.back().t_ns) + machine_minus_monotonic_ns);
  for (const std::int64_t end = PulseChip::now_ns() + kLongestWait_ns; complete_ <= last;)
    ASSERT_TRUE(take_for_a_moment(end)) << "the backend does not say that all edges have come";
}

std::size_t GpioRig::edges_of(EdgeKind kind, std::uint8_t line) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(edges, [&](const Edge& edge) { return edge.kind == kind && edge.line == line; }));
}

Sealed GpioRig::seal(std::int64_t begin_ns, double seconds) const {
  Ring ring;
  RingSink sink(ring);
  const NodeConfig& node = vehicle.node[0];
  BlockPacker packer(vehicle, node, 5, sink, nullptr);
  packer.start();
  const double period_ns = 1e9 / node.rate_hz;
  std::size_t next = 0;
  for (std::int64_t k = 0; k < static_cast<std::int64_t>(seconds * node.rate_hz); ++k) {
    Scan scan;
    scan.index = k;
    scan.time = node_time_from_ns(begin_ns + machine_minus_monotonic_ns +
                                  std::llround(static_cast<double>(k) * period_ns));
    const std::size_t first = next;
    while (next < edges.size() && edges[next].time <= scan.time) ++next;
    packer.add({&scan, 1}, std::span(edges).subspan(first, next - first), false);
  }
  packer.stop();
  packer.device_ended();
  Sealed sealed{.blocks = {}, .faulty_turns = packer.encoder_faults(0).turns};
  for (std::int64_t sequence = 1; sequence < ring.next(); ++sequence)
    if (ring.get(sequence).kind == BlockKind::kScan) sealed.blocks.push_back(decode_scan(ring.get(sequence)));
  return sealed;
}

std::jthread hog_processor(int priority, std::int64_t from_ns, std::int64_t until_ns) {
  std::jthread hog([=] {
    std::this_thread::sleep_until(WallTime(std::chrono::nanoseconds(from_ns)));
    while (PulseChip::now_ns() < until_ns) {
    }
  });
  const sched_param parameter{.sched_priority = priority};
  ::pthread_setschedparam(hog.native_handle(), SCHED_FIFO, &parameter);
  return hog;
}

}  // namespace roadbalance::test
