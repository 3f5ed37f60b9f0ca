#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <complex>
#include <cstdio>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/bus/codec.hpp"
#include "common/dsp/cross_spectra.hpp"
#include "common/dsp/transfer_function.hpp"
#include "host/analysis/spectra/envelopes.hpp"
#include "host/analysis/spectra/spectra.hpp"
#include "host/recording/levels.hpp"

// The cost of the analyser's live view: three nodes of 16 channels at 2 kHz; cross spectra of all pairs, 4096
// samples, Hann, 50 % overlap.  "core_percent" is what a stage costs of one core in real time; the table at
// the end gives each stage's share of the whole.

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

VehicleConfig vehicle() {
  VehicleConfig vehicle;
  for (int n = 0; n < kNodes; ++n) {
    NodeConfig node{"node", n + 1, kRateHz, {}};
    for (int c = 0; c < kAccelerations; ++c) {
      ChannelConfig& channel = node.channel.emplace_back();
      channel.scale_m_s2_per_count = 1e-5;
    }
    vehicle.node.push_back(node);
  }
  return vehicle;
}

/// As nodes send them, in order.
const std::vector<SealedBlock>& sealed() {
  static const auto blocks = [] {
    std::vector<SealedBlock> made(kSeconds * 2000 / kScansPerBlock * kNodes);
    std::mt19937 random(3);
    std::uniform_int_distribution<std::int32_t> noise(-1'000'000, 1'000'000);
    for (std::size_t b = 0; b < made.size(); ++b) {
      ScanBlock block;
      const auto number = static_cast<std::int64_t>(b / kNodes);
      block.header = {
          static_cast<std::int32_t>(b % kNodes) + 1, 1, number + 1, number * kScansPerBlock, kScansPerBlock,
          number * kScansPerBlock * 500'000};
      block.period_ps = 500'000'000;
      for (auto& row : block.counts)
        for (auto& count : row) count = noise(random);
      seal(block, made[b]);
    }
    return made;
  }();
  return blocks;
}

/// CRC and order of bytes.
void decode_blocks(benchmark::State& state) {
  SealedBlock taken;
  for (auto _ : state)
    for (const SealedBlock& block : sealed())
      if (accept(block.bytes(), taken) == Refusal::kNone) benchmark::DoNotOptimize(decode_scan(taken));
  report(state);
}
BENCHMARK(decode_blocks)->Unit(benchmark::kMillisecond);

/// Gives all blocks, decoded before, to a meter for each node, and the meters to `tell` after every
/// `blocks_between` blocks of each node.
template <typename Make, typename Tell>
void meter(benchmark::State& state, const Make& make, const Tell& tell, int blocks_between) {
  const VehicleConfig car = vehicle();
  std::vector<ScanBlock> blocks;
  for (const SealedBlock& block : sealed()) blocks.push_back(decode_scan(block));
  for (auto _ : state) {
    std::vector<decltype(make(car, 0))> meters;
    for (int n = 0; n < kNodes; ++n) meters.push_back(make(car, static_cast<std::size_t>(n)));
    int since = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      meters[b % kNodes].add(blocks[b]);
      if (++since % (blocks_between * kNodes) == 0)
        for (auto& one : meters) tell(one);
    }
  }
  report(state);
}

/// Ten times a second.
void levels(benchmark::State& state) {
  meter(
      state, [](const VehicleConfig& car, std::size_t n) { return LevelMeter(car, car.node[n]); },
      [](LevelMeter& one) { benchmark::DoNotOptimize(one.take()); }, 10);
}
BENCHMARK(levels)->Unit(benchmark::kMillisecond);

/// Envelopes of all channels, twenty times a second: somebody looks at each of them.
void envelopes(benchmark::State& state) {
  meter(
      state, [](const VehicleConfig& car, std::size_t n) { return EnvelopeMeter(car.node[n]); },
      [](EnvelopeMeter& one) {
        for (std::int32_t c = 0; c < kAccelerations; ++c)
          benchmark::DoNotOptimize(encode(one.envelope(c).value_or(Envelope{})));
      },
      5);
}
BENCHMARK(envelopes)->Unit(benchmark::kMillisecond);

/// Spectra of all channels over ten seconds, once a second.
void spectra_for_everybody(benchmark::State& state) {
  meter(
      state, [](const VehicleConfig& car, std::size_t n) { return SpectrumMeter(car.node[n]); },
      [](SpectrumMeter& one) { benchmark::DoNotOptimize(one.take()); }, 100);
}
BENCHMARK(spectra_for_everybody)->Unit(benchmark::kMillisecond);

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

/// A display of one pair asks for this, ten times a second.
void one_pair_shown(benchmark::State& state) {
  CrossSpectra spectra({.welch = kWelch, .channels = kAll, .memory = 20});
  spectra.add(samples());
  for (auto _ : state)
    benchmark::DoNotOptimize(transfer_function(spectra.density(0), spectra.density(17),
                                               spectra.density(0, 17), spectra.independent_averages()));
  report(state, 0.1);
}
BENCHMARK(one_pair_shown)->Unit(benchmark::kMicrosecond);

/// The allowed percentage of a core for the live view of 3 x 16 channels at 2 kHz with all pairs, blocks of
/// 4096.
constexpr double kMost_percent = 3.0;

constexpr std::array kStages{"decode_blocks", "levels",       "envelopes",     "spectra_for_everybody",
                             "transforms",    "all_pairs/48", "one_pair_shown"};

/// Prints as usual, and keeps what each stage costs.
class Shares : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs)
      if (const auto found = run.counters.find("core_percent"); found != run.counters.end())
        percent_[run.benchmark_name()] = found->second;
  }

  /// Stages of the live view that were not measured: "levels, transforms".
  std::string missing() const {
    std::string names;
    for (const char* stage : kStages)
      if (!percent_.contains(stage)) names += (names.empty() ? "" : ", ") + std::string(stage);
    return names;
  }

  /// Prints the stages of the live view, all of which were measured.
  /// @return percent of a core of all of them
  double print() const {
    std::map<std::string, double> stages;
    for (const char* stage : kStages) stages[stage] = percent_.at(stage);
    stages["all_pairs/48"] -= stages["transforms"];  // which it holds
    double whole = 0.0;
    for (const auto& [stage, percent] : stages) whole += percent;
    std::printf("\n%-24s %8s %8s\n", "stage", "core", "share");
    for (const auto& [stage, percent] : stages)
      std::printf("%-24s %6.2f %% %6.1f %%\n", stage == "all_pairs/48" ? "sums of all pairs" : stage.c_str(),
                  percent, 100.0 * percent / whole);
    std::printf("%-24s %6.2f %%\n", "live view", whole);
    return whole;
  }

 private:
  std::map<std::string, double> percent_;
};

}  // namespace
}  // namespace roadbalance

int main(int argc, char** argv) {
  const bool lists = std::any_of(
      argv, argv + argc, [](const char* word) { return std::string_view(word) == "--benchmark_list_tests"; });
  benchmark::Initialize(&argc, argv);
  const bool filters = !benchmark::GetBenchmarkFilter().empty();
  roadbalance::Shares shares;
  benchmark::RunSpecifiedBenchmarks(&shares);
  if (lists) return 0;
  if (const std::string missing = shares.missing(); !missing.empty()) {
    std::fprintf(stderr, "bench-spectra: the live view was not judged, for these were not measured: %s\n",
                 missing.c_str());
    return filters ? 0 : 1;
  }
  const double percent = shares.print();
  if (percent < roadbalance::kMost_percent) return 0;
  std::fprintf(stderr, "bench-spectra: the live view takes %.2f %% of a core; %.0f %% are allowed\n", percent,
               roadbalance::kMost_percent);
  return 1;
}
