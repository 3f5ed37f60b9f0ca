#pragma once

#include "firmware/backends/usb/test/board_feed.hpp"
#include "firmware/test/vehicle.hpp"

namespace roadbalance::test {

inline constexpr double kRateHz = 10'000.0;
inline constexpr int kTeeth = 100;

/// Twelve channels and the lines of two wheels at 10 kHz.
inline VehicleConfig vehicle() {
  VehicleConfig vehicle = one_node_vehicle(kRateHz, kTeeth);
  vehicle.node[0].channel.resize(12, vehicle.node[0].channel[0]);
  return vehicle;
}

/// The value of a board's conversion k at an input.
inline std::int32_t counts_of(std::int64_t conversion, std::size_t channel) {
  return static_cast<std::int32_t>((conversion * 7919 + static_cast<std::int64_t>(channel) * 104'729) %
                                   8'000'000) -
         4'000'000;
}

/// A board whose inputs are counts_of().
inline Bench bench(double ppm = 0.0) {
  Bench bench;
  bench.oscillator_ppm = ppm;
  bench.words = [](std::int64_t conversion, MachineTime) {
    board::ScanWords words{};
    for (std::size_t k = 0; k < board::kInputChannels; ++k)
      words[k] = static_cast<std::uint32_t>(counts_of(conversion, k)) & 0xFFFFFF;
    return words;
  };
  return bench;
}

}  // namespace roadbalance::test
