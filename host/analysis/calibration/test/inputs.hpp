#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "common/dsp/state_filter.hpp"
#include "common/test/source.hpp"
#include "host/analysis/calibration/channel_comparison.hpp"

namespace roadbalance::test {

inline constexpr double kRate_hz = 2000.0;
inline constexpr int kSteps = 4;  ///< of the filters in a scan
inline constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Inputs of a node: filters of their own behind one signal, each with a gain and noise.
struct Inputs {
  FilterConfig filter;
  std::array<double, kChannels> cutoff_factor{}, gain{};
  double noise = 0.0;  ///< rms, full scale 1
  unsigned seed = 3;

  Inputs() {
    cutoff_factor.fill(1.0);
    gain.fill(1.0);
  }

  /// Their counts of `signal` (of seconds), block by block; the first second is left out.
  void run(double seconds, const std::function<double(double)>& signal,
           const std::function<void(const ScanBlock&)>& take) const {
    std::vector<StateFilter> filters;
    for (const double factor : cutoff_factor)
      filters.emplace_back(discretise_ramp_invariant(butterworth(filter.order, filter.cutoff_hz * factor),
                                                     1.0 / (kRate_hz * kSteps)),
                           1);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    ScanBlock block;
    block.period_ps = 500'000'000;
    const auto scans = static_cast<std::int64_t>(seconds * kRate_hz);
    for (std::int64_t scan = 0; scan < scans; ++scan) {
      for (int step = 1; step <= kSteps; ++step) {
        const double t = static_cast<double>(scan * kSteps + step - kSteps) / (kRate_hz * kSteps);
        const double u = signal(t);
        for (std::size_t c = 0; c < kChannels; ++c)
          filters[c].update(Eigen::Array<double, 1, 1>(gain[c] * u));
      }
      const auto row = static_cast<std::size_t>(scan % kScansPerBlock);
      for (std::size_t c = 0; c < kChannels; ++c)
        block.counts[row][c] = static_cast<std::int32_t>(
            std::lround((filters[c].states()(0, 0) + noise * normal(random)) * kFullScaleCounts));
      if (row + 1 < kScansPerBlock || scan < std::lround(kRate_hz)) continue;
      block.header = {1, 1, 1 + scan, scan + 1 - kScansPerBlock, kScansPerBlock, scan * 500'000};
      take(block);
    }
  }
};

inline std::function<double(double)> hiss(double rms) {
  return [rms, random = std::mt19937(11), normal = std::normal_distribution<double>()](double) mutable {
    return rms * normal(random);
  };
}

inline NodeConfig node_of(const std::function<void(NodeConfig&)>& change = {}) {
  NodeConfig node = VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "car").node[0];
  if (change) change(node);
  return node;
}

inline ChannelComparison::Result compare(const NodeConfig& node, const Inputs& inputs, double seconds,
                                         ChannelComparison::Settings settings = {}) {
  ChannelComparison comparison(node, settings);
  inputs.run(seconds, hiss(0.2), [&](const ScanBlock& block) { comparison.add(block); });
  return comparison.result();
}

}  // namespace roadbalance::test
