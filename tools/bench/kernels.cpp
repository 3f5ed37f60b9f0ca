#include <benchmark/benchmark.h>

#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/dsp/psd.hpp"
#include "common/multibody/affine_model.hpp"
#include "common/vehicle/vehicle_description.hpp"
#include "embedded/demo_vehicle.hpp"
#include "firmware/epoch_packer.hpp"
#include "host/analysis/balance/compensate.hpp"
#include "host/analysis/identify/drive_estimator.hpp"
#include "host/recording/levels.hpp"
#include "sim/front_end.hpp"

// The cost of each stage, in times real time of one node of 16 channels at 2 kHz ("real_time_x"); and the
// model.

namespace roadbalance {
namespace {

const VehicleConfig& vehicle() {
  static const auto config =
      VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml");
  return config;
}

/// All blocks of a drive, both nodes, as they would come from the bus.
std::vector<SealedBlock> blocks_of(double seconds) {
  std::vector<SealedBlock> list;
  for (const NodeConfig& node : vehicle().node) {
    const auto front_end =
        sim::open_sim_front_end({"?seed=1&rate=max&seconds=" + std::to_string(seconds), vehicle(), node});
    pack_epoch(*front_end, vehicle(), node, 1, [&](const SealedBlock& block) { list.push_back(block); });
  }
  return list;
}

const std::vector<SealedBlock>& drive(double seconds) {
  static const std::vector<SealedBlock> blocks = blocks_of(seconds);
  return blocks;
}

void report(benchmark::State& state, double node_seconds_each) {
  state.counters["real_time_x"] =
      benchmark::Counter(node_seconds_each, benchmark::Counter::kIsIterationInvariantRate);
}

constexpr double kDrive_s = 30.0;

void simulate_and_seal(benchmark::State& state) {
  const NodeConfig& node = vehicle().node.front();
  for (auto _ : state) {
    const auto front_end = sim::open_sim_front_end({"?seed=1&rate=max&seconds=5", vehicle(), node});
    pack_epoch(*front_end, vehicle(), node, 1,
               [](const SealedBlock& block) { benchmark::DoNotOptimize(block.size); });
  }
  report(state, 5.0);
}
BENCHMARK(simulate_and_seal)->Unit(benchmark::kMillisecond);

void accept_blocks(benchmark::State& state) {
  const auto& blocks = drive(kDrive_s);
  SealedBlock out;
  for (auto _ : state)
    for (const auto& block : blocks) benchmark::DoNotOptimize(accept(block.bytes(), out));
  report(state, 2.0 * kDrive_s);
}
BENCHMARK(accept_blocks)->Unit(benchmark::kMillisecond);

void meter_levels(benchmark::State& state) {
  const auto& blocks = drive(kDrive_s);
  LevelMeter meter(vehicle(), vehicle().node.front());
  for (auto _ : state) {
    for (const auto& block : blocks)
      if (block.kind == BlockKind::kScan) meter.add(decode_scan(block));
    benchmark::DoNotOptimize(meter.take());
  }
  report(state, 2.0 * kDrive_s);
}
BENCHMARK(meter_levels)->Unit(benchmark::kMillisecond);

void identify_blocks(benchmark::State& state) {
  const auto& blocks = drive(kDrive_s);
  for (auto _ : state) {
    DriveEstimator estimator(vehicle());
    for (const auto& block : blocks) estimator.consume(block);
    benchmark::DoNotOptimize(estimator.version());
  }
  report(state, 2.0 * kDrive_s);
}
BENCHMARK(identify_blocks)->Unit(benchmark::kMillisecond);

constexpr double kLong_s = 160.0;

/// The demo car with the finest stock of weights that a vehicle.toml may have, and all rims full.
VehicleConfig with_many_weights() {
  VehicleConfig car = vehicle();
  for (WheelConfig& wheel : car.wheel) {
    wheel.stock = {.step_g = 1.0,
                   .heaviest_g = 100.0,
                   .place = {{.radius_m = 0.19}, {.radius_m = 0.16}},
                   .raster_rad = std::numbers::pi / 180.0};
    for (std::size_t k = 0; k < kMostFittedWeights; ++k)
      wheel.fitted.push_back({20.0, 0.7 * static_cast<double>(k), wheel.stock.place[k % 2]});
  }
  return car;
}

/// As the live analyser does it: an estimate with its covariance for every second of driving, and the weights
/// that follow from it for four wheels ("plans": of how many).
/// "core_percent" is what that costs of one core in real time.
void estimate_every_second(benchmark::State& state) {
  static const auto blocks = blocks_of(kLong_s);
  static const VehicleConfig car = with_many_weights();
  int plans = 0;
  for (auto _ : state) {
    DriveEstimator estimator(car);
    std::int64_t version = 0;
    for (const auto& block : blocks) {
      estimator.consume(block);
      if (std::exchange(version, estimator.version()) == version) continue;
      const DriveEstimate& estimate = estimator.estimate();
      for (std::size_t w = 0; w < kWheels; ++w)
        plans += compensate(estimate.balance[w], car.wheel[w], car.limits).advice == Advice::kSteps;
    }
  }
  report(state, 2.0 * kLong_s);
  state.counters["plans"] = benchmark::Counter(plans, benchmark::Counter::kAvgIterations);
  state.counters["core_percent"] = benchmark::Counter(
      kLong_s / 100.0, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(estimate_every_second)->Unit(benchmark::kMillisecond);

void average_spectrum(benchmark::State& state) {
  WelchPsd psd({.rate_hz = 2000.0, .segment = 4000});
  const std::vector<double> samples(20'000, 1.0);
  for (auto _ : state) psd.add(samples);
  state.counters["channels_real_time_x"] =
      benchmark::Counter(10.0, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(average_spectrum)->Unit(benchmark::kMillisecond);

/// Description of the 7-degree-of-freedom car to the matrices of its 33 parameters; promised within 1 s.
void derive_seven_dof(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(affine_model(derive(description_of(vehicle()))));
}
BENCHMARK(derive_seven_dof)->Unit(benchmark::kMillisecond);

void evaluate_linear_model(benchmark::State& state) {
  const Geometry geometry = geometry_of(vehicle().model);
  ParameterVector parameters = nominal_parameters(vehicle());
  for (auto _ : state) {
    benchmark::DoNotOptimize(parameters.data());
    benchmark::DoNotOptimize(linear_model(geometry, parameters));
  }
}
BENCHMARK(evaluate_linear_model)->Unit(benchmark::kNanosecond);

}  // namespace
}  // namespace roadbalance

BENCHMARK_MAIN();
