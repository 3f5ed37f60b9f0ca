#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "common/bus/codec.hpp"
#include "common/test/source.hpp"
#include "host/analysis/spectra/joint_spectra.hpp"

namespace roadbalance::test {

inline constexpr std::int64_t kPeriodNs = 500'000;
inline constexpr ChannelPlace kFront{0, 2}, kRear{1, 5};

inline const VehicleConfig& car() {
  static const VehicleConfig vehicle = VehicleConfig::read_file(source_path("sim/demo/vehicle.toml"));
  return vehicle;
}

/// White noise of 1 m/s^2 at the front; half of it, three samples later, at the rear.
class NoiseDrive {
 public:
  SealedBlock next(int node_index, std::int32_t overload = 0) {
    auto& number = number_[static_cast<std::size_t>(node_index)];
    const NodeConfig& node = car().node[static_cast<std::size_t>(node_index)];
    ScanBlock block;
    block.header = {
        node.id, 1, number + 1, number * kScansPerBlock, kScansPerBlock, number * kScansPerBlock * kPeriodNs};
    block.period_ps = kPeriodNs * 1000;
    block.overload = overload;
    const auto c = static_cast<std::size_t>(node_index == 0 ? kFront.channel : kRear.channel);
    for (int row = 0; row < kScansPerBlock; ++row) {
      const std::int64_t k = number * kScansPerBlock + row;
      const double value = node_index == 0 ? noise(k) : 0.5 * noise(k - 3);
      const ChannelConfig& channel = node.channel[c];
      block.counts[static_cast<std::size_t>(row)][c] =
          static_cast<std::int32_t>(std::lround((value - channel.to_si(0.0)) / channel.scale_m_s2_per_count));
    }
    ++number;
    SealedBlock sealed;
    seal(block, sealed);
    return sealed;
  }

 private:
  static double noise(std::int64_t k) {
    static const auto values = [] {
      std::array<double, 32'768> list{};
      std::mt19937 random(17);
      std::normal_distribution<double> normal;
      for (double& value : list) value = normal(random);
      return list;
    }();
    return values[static_cast<std::size_t>(k + 3) % values.size()];
  }
  std::array<std::int64_t, 2> number_{};
};

}  // namespace roadbalance::test
