#include <benchmark/benchmark.h>

#include <complex>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/cross_spectra.hpp"
#include "common/dsp/transfer_function.hpp"

// Cross spectra of all pairs: three nodes of 16 channels at 2 kHz, 4096 samples, Hann, 50 % overlap.
// "core_percent" is what a stage costs of one core in real time.

namespace roadbalance {
namespace {

constexpr int kNodes = 3, kPerNode = 16, kAll = kNodes * kPerNode;
constexpr double kRateHz = 2000.0;
constexpr Eigen::Index kSeconds = 16;  // of data an iteration
const WelchPsd::Settings kWelch{.rate_hz = kRateHz, .segment = 4096};

const Eigen::MatrixXd& samples() {
  static const Eigen::MatrixXd x = Eigen::MatrixXd::Random(kAll, kSeconds * 2000);
  return x;
}

void report(benchmark::State& state, double seconds_each = kSeconds) {
  state.counters["core_percent"] = benchmark::Counter(
      seconds_each / 100.0, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// The transforms alone: every channel by itself.
void transforms(benchmark::State& state) {
  WelchPsd psd(kWelch);
  for (auto _ : state)
    for (int c = 0; c < kAll; ++c) {
      const std::vector<double> x(samples().row(c).begin(), samples().row(c).end());
      psd.add(x);
    }
  report(state);
}
BENCHMARK(transforms)->Unit(benchmark::kMillisecond);

void all_pairs(benchmark::State& state) {
  CrossSpectra spectra({.welch = kWelch, .channels = static_cast<int>(state.range(0)), .memory = 20});
  const Eigen::Index channels = state.range(0), block = 20;  // a datagram's scans at a time
  for (auto _ : state)
    for (Eigen::Index n = 0; n < samples().cols(); n += block)
      spectra.add(samples().block(0, n, channels, block));
  benchmark::DoNotOptimize(spectra.density(0, 1));
  report(state);
}
BENCHMARK(all_pairs)->Arg(kPerNode)->Arg(kAll)->Unit(benchmark::kMillisecond);

/// The peer: the textbook's update of each bin's matrix by Eigen, with the transforms taken for done.
void pairs_bin_by_bin(benchmark::State& state) {
  const Eigen::Index channels = state.range(0), bins = kWelch.segment / 2 + 1;
  std::vector<Eigen::MatrixXcd> sum(static_cast<std::size_t>(bins),
                                    Eigen::MatrixXcd::Zero(channels, channels));
  const Eigen::MatrixXcd lines = Eigen::MatrixXcd::Random(channels, bins);
  const auto segments = static_cast<int>(kSeconds * 2000 / (kWelch.segment / 2));
  for (auto _ : state)
    for (int s = 0; s < segments; ++s)
      for (Eigen::Index k = 0; k < bins; ++k)
        sum[static_cast<std::size_t>(k)].selfadjointView<Eigen::Upper>().rankUpdate(lines.col(k));
  benchmark::DoNotOptimize(sum);
  report(state);
}
BENCHMARK(pairs_bin_by_bin)->Arg(kPerNode)->Arg(kAll)->Unit(benchmark::kMillisecond);

/// What a display of one pair asks for, ten times a second.
void one_pair_shown(benchmark::State& state) {
  CrossSpectra spectra({.welch = kWelch, .channels = kAll, .memory = 20});
  spectra.add(samples());
  for (auto _ : state)
    benchmark::DoNotOptimize(transfer_function(spectra.density(0), spectra.density(17),
                                               spectra.density(0, 17), spectra.independent_averages()));
  report(state, 0.1);
}
BENCHMARK(one_pair_shown)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace roadbalance

BENCHMARK_MAIN();
