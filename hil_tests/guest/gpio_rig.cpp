#include "hil_tests/guest/gpio_rig.hpp"

#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <array>

#include "firmware/test/vehicle.hpp"

namespace roadbalance::test {

void add_pulse(std::vector<gpio_pulse_step>& steps, unsigned line, std::int64_t begin_ns,
               std::int64_t period_ns) {
  steps.push_back({static_cast<std::uint64_t>(begin_ns), line, 1});
  steps.push_back({static_cast<std::uint64_t>(begin_ns + period_ns / 2), line, 0});
}

std::vector<gpio_pulse_step> in_order(std::vector<gpio_pulse_step> steps) {
  std::ranges::stable_sort(steps, {}, &gpio_pulse_step::t_ns);
  return steps;
}

GpioRig::GpioRig(std::vector<LineConfig> lines, int teeth) : vehicle(one_node_vehicle(2000.0, teeth)) {
  vehicle.node[0].wiring.line = std::move(lines);
  edges.reserve(200'000);  // fresh memory costs guest time
  source = open_gpio({PulseChip::name(), vehicle, vehicle.node[0]}, [this](const std::string& text) {
             warnings += text + '\n';
           }).side;
}

void GpioRig::take() {
  static std::array<Edge, 4096> some;
  const SideRead read = source->take(some, {});
  for (std::size_t k = 0; k < read.edges; ++k) {
    EXPECT_GT(some[k].time, edges.empty() ? NodeTime::min() : edges.back().time) << "edges come in order";
    EXPECT_GE(some[k].time, complete_) << "an edge came after it was said that all had come";
    edges.push_back(some[k]);
  }
  EXPECT_GE(read.complete_until, complete_);
  complete_ = read.complete_until;
}

void GpioRig::take_for(std::int64_t duration_ns) {
  for (const std::int64_t end = PulseChip::now_ns() + duration_ns; PulseChip::now_ns() < end; take()) {
    const timespec pause{0, 5'000'000};
    ::nanosleep(&pause, nullptr);
  }
  take();
}

void GpioRig::play(const std::vector<gpio_pulse_step>& steps) {
  chip.play(steps);
  take_for(static_cast<std::int64_t>(steps.back().t_ns) - PulseChip::now_ns() + 20'000'000);
  const auto played = chip.played();
  truth.insert(truth.end(), played.begin(), played.end());
}

std::size_t GpioRig::edges_of(EdgeKind kind, std::uint8_t line) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(edges, [&](const Edge& edge) { return edge.kind == kind && edge.line == line; }));
}

std::jthread hog_processor(int priority, std::int64_t from_ns, std::int64_t until_ns) {
  std::jthread hog([=] {
    const timespec from{from_ns / 1'000'000'000, from_ns % 1'000'000'000};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &from, nullptr);
    while (PulseChip::now_ns() < until_ns) {
    }
  });
  const sched_param parameter{.sched_priority = priority};
  ::pthread_setschedparam(hog.native_handle(), SCHED_FIFO, &parameter);
  return hog;
}

}  // namespace roadbalance::test
