#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <ctime>
#include <numbers>
#include <vector>

#include "common/angle/wheel_encoder.hpp"
#include "host/analysis/angle/recorded_angle.hpp"
#include "sim/pulse_train.hpp"

// The cost of following the encoders of a car: "core_percent" of one core, in real time.

namespace roadbalance {
namespace {

constexpr int kWheels = 4;
constexpr double kDrive_s = 10.0;
constexpr int kInstants = 40;  // a block of 10 ms, twice the scan rate, as references are made
constexpr double kBlock_s = 0.01;

/// A wheel, and how it turns.
struct Ring {
  int teeth;
  double edges_hz, torsion_rad, jitter_s;
};
/// As fast as any wheel's teeth come; and a wheel speed sensor's at 100 km/h, without torsion, so that the
/// angle is fitted to as long a stretch as ever.
constexpr std::array<Ring, 2> kRing{Ring{1000, 20'000.0, 0.02, 2e-6}, Ring{96, 1250.0, 0.0, 5e-6}};

std::vector<Edge> edges_of(const Ring& ring) {
  return sim::PulseTrain{.angle_rad =
                             [&](double t) {
                               return 2.0 * std::numbers::pi * ring.edges_hz / ring.teeth * t +
                                      ring.torsion_rad * std::sin(2.0 * std::numbers::pi * 13.0 * t);
                             },
                         .teeth = ring.teeth,
                         .jitter_s = ring.jitter_s}
      .edges(0.0, kDrive_s);
}

/// CPU time of the runs since `start`, each of which followed one wheel for the drive.
void report(benchmark::State& state, std::clock_t start, std::size_t edges) {
  const double cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  state.counters["core_percent"] =
      100.0 * kWheels * cpu_s / (kDrive_s * static_cast<double>(state.iterations()));
  state.counters["edges"] = static_cast<double>(edges);
}

/// Four wheels, edges to angles, block by block as a node does.
void follow_live(benchmark::State& state) {
  const Ring& ring = kRing[static_cast<std::size_t>(state.range(0))];
  const std::vector<Edge> edges = edges_of(ring);
  const std::clock_t start = std::clock();
  for (auto _ : state) {
    WheelEncoder encoder({.pulses_per_turn = ring.teeth});
    std::array<double, kInstants> angle;
    auto edge = edges.begin();
    for (double block_s = 0.0; block_s + 0.2 < kDrive_s; block_s += kBlock_s) {
      const NodeTime first = node_time_from_ns(std::llround(block_s * 1e9));
      const NodeTime last = first + NodeClock::duration(9'750'000);
      for (; edge != edges.end() && edge->time < encoder.complete_at(last); ++edge)
        encoder.add(edge->time, edge->kind);
      benchmark::DoNotOptimize(encoder.angles(first, 2.5e5, angle));
    }
  }
  report(state, start, edges.size());
}
BENCHMARK(follow_live)->Unit(benchmark::kMillisecond)->Arg(0)->Arg(1);

/// The least that could be done: a straight line between the edges around each instant, nothing checked or
/// learned.
void interpolate_linearly(benchmark::State& state) {
  const Ring& ring = kRing[static_cast<std::size_t>(state.range(0))];
  const std::vector<Edge> edges = edges_of(ring);
  const double pitch_rad = 2.0 * std::numbers::pi / ring.teeth;
  const std::clock_t start = std::clock();
  for (auto _ : state) {
    std::array<double, kInstants> angle;
    std::size_t next = 1;
    for (double block_s = 0.0; block_s + 0.2 < kDrive_s; block_s += kBlock_s) {
      for (std::size_t k = 0; k < angle.size(); ++k) {
        const NodeTime at =
            node_time_from_ns(std::llround(1e9 * block_s) + 250'000 * static_cast<std::int64_t>(k));
        while (edges[next].time <= at) ++next;
        const std::chrono::duration<double> since = at - edges[next - 1].time,
                                            whole = edges[next].time - edges[next - 1].time;
        angle[k] = pitch_rad * (static_cast<double>(next - 1) + since / whole);
      }
      benchmark::DoNotOptimize(angle);
    }
  }
  report(state, start, edges.size());
}
BENCHMARK(interpolate_linearly)->Unit(benchmark::kMillisecond)->Arg(0)->Arg(1);

/// The same edges again from the record.
void follow_recorded(benchmark::State& state) {
  const Ring& ring = kRing[static_cast<std::size_t>(state.range(0))];
  const std::vector<Edge> edges = edges_of(ring);
  const std::clock_t start = std::clock();
  for (auto _ : state) {
    RecordedAngle recorded({.pulses_per_turn = ring.teeth}, edges);
    std::array<double, kInstants> angle;
    for (double block_s = 0.2; block_s + 0.2 < kDrive_s; block_s += kBlock_s)
      benchmark::DoNotOptimize(recorded.angles(node_time_from_ns(std::llround(block_s * 1e9)), 2.5e5, angle));
  }
  report(state, start, edges.size());
}
BENCHMARK(follow_recorded)->Unit(benchmark::kMillisecond)->Arg(0)->Arg(1);

}  // namespace
}  // namespace roadbalance

BENCHMARK_MAIN();
