#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include "common/bus/codec.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance::test {

inline constexpr double kSyntheticRate_hz = 1000.0;

/// Two nodes: "rear" reads both rear wheels and has channels a, b; "other" has a channel far, whose scans are
/// those of the same instants.  The filter is too far up to matter.
inline VehicleConfig rotor_vehicle(double ratio, std::vector<int> wheels) {
  VehicleConfig vehicle{};
  vehicle.name = "synthetic";
  for (int w = 0; w < kWheels; ++w) {
    auto& wheel = vehicle.wheel[static_cast<std::size_t>(w)];
    wheel.name = kWheelNames[static_cast<std::size_t>(w)];
    wheel.rolling_radius_m = 0.3;
    wheel.encoder = {.pulses_per_turn = 96};
    if (w < 2) continue;
    wheel.node = "rear";
    wheel.line = w - 2;
  }
  const auto channel = [](const std::string& name) {
    ChannelConfig c;
    c.name = name;
    c.mount = "body";
    c.scale_m_s2_per_count = 1e-5;
    return c;
  };
  vehicle.node.push_back(
      {.name = "rear", .id = 3, .rate_hz = kSyntheticRate_hz, .channel = {channel("a"), channel("b")}});
  vehicle.node.push_back(
      {.name = "other", .id = 4, .rate_hz = kSyntheticRate_hz, .channel = {channel("far")}});
  vehicle.filter = {.order = 4, .cutoff_hz = 1e6};
  vehicle.rotor.push_back({.name = "shaft",
                           .wheel = std::move(wheels),
                           .ratio = ratio,
                           .plane = {{.name = "front", .position_m = {0, 0, 0}, .weight_radius_m = 0.05},
                                     {.name = "back", .position_m = {-1, 0, 0}, .weight_radius_m = 0.05}}});
  return vehicle;
}

/// A drive: angles of both rear wheels, and what rotates with the shaft in channels a, b and far.
struct SyntheticDrive {
  std::function<double(double)> left_rad, right_rad;
  std::function<double(double)> shaft_rad;  ///< of the true rotor
  std::array<std::complex<double>, 3> vector{};
  double noise = 0.0;  ///< m/s^2 rms
  double seconds = 40.0;
  std::uint64_t seed = 1;
  double silent_from_s = 1e9, silent_to_s = 1e9;  ///< the wheels' angles are not known
  std::function<double(double)> beside_rad{};  ///< of another rotor in the same channels; none: there is none
  std::array<std::complex<double>, 3> beside{};

  /// Blocks of both nodes in turn.
  template <typename Take>
  void seal_into(Take&& take) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0.0, 1.0);
    const auto blocks = static_cast<std::int64_t>(seconds * kSyntheticRate_hz / kScansPerBlock);
    for (std::int64_t n = 0; n < blocks; ++n) {
      ScanBlock rear, other;
      rear.header = {3, 9, n + 1, n * kScansPerBlock, kScansPerBlock, n * kScansPerBlock * 1'000'000};
      other.header = rear.header;
      other.header.node = 4;
      rear.period_ps = other.period_ps = 1'000'000'000;
      for (std::size_t row = 0; row < kScansPerBlock; ++row) {
        const double t =
            static_cast<double>(n * kScansPerBlock + static_cast<std::int64_t>(row)) / kSyntheticRate_hz;
        const auto show = [&](std::size_t k) {
          double value = (vector[k] * std::polar(1.0, shaft_rad(t))).real() + noise * normal(random);
          if (beside_rad) value += (beside[k] * std::polar(1.0, beside_rad(t))).real();
          return static_cast<std::int32_t>(std::lround(value * 1e5));
        };
        rear.counts[row][0] = show(0);
        rear.counts[row][1] = show(1);
        other.counts[row][0] = show(2);
        const double angle[2] = {left_rad(t), right_rad(t)};
        for (std::size_t line = 0; line < 2; ++line) {
          rear.counts[row][kAccelerations + 2 * line] =
              static_cast<std::int32_t>(std::lround(std::sin(angle[line]) * kFullScaleCounts));
          rear.counts[row][kAccelerations + 2 * line + 1] =
              static_cast<std::int32_t>(std::lround(std::cos(angle[line]) * kFullScaleCounts));
        }
        if (silent_from_s <= t && t < silent_to_s) rear.quality |= kQualityNoReference0;
      }
      SealedBlock sealed;
      seal(rear, sealed);
      take(sealed);
      seal(other, sealed);
      take(sealed);
    }
  }
};

}  // namespace roadbalance::test
