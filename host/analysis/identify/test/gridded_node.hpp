#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "common/types/block.hpp"
#include "host/analysis/identify/grid_stream.hpp"

namespace roadbalance::test {

inline constexpr double kAmplitude = 1e6;  // counts

/// Signal of every channel: 1, 18, 25 and 60 Hz, as a function of host time.
inline double signal(double time_s, std::size_t channel) {
  double sum = 0.0;
  for (const double hz : {1.0, 18.0, 25.0, 60.0})
    sum += std::sin(2.0 * std::numbers::pi * hz * time_s + static_cast<double>(channel));
  return kAmplitude * sum;
}

/// A node: clock = offset + (1 + drift) host time; its converter runs `ppm` fast.
struct Node {
  double rate_hz = 2000.0;
  double offset_s = 0.0, drift = 0.0, ppm = 0.0;
  double begin_s = 0.0;  ///< host time of scan 0
  std::int64_t epoch = 5;

  double host_s(std::int64_t scan) const {
    return begin_s + static_cast<double>(scan) / (rate_hz * (1.0 + 1e-6 * ppm));
  }
  std::int64_t node_ns(double host_s) const {
    return std::llround(1e9 * (offset_s + (1.0 + drift) * host_s));
  }

  ScanBlock block(std::int64_t number) const {
    ScanBlock block;
    const std::int64_t first = number * kScansPerBlock;
    block.header = {.node = 1,
                    .epoch = epoch,
                    .sequence = number + 1,
                    .first_scan = first,
                    .scans = kScansPerBlock,
                    .time_ns = node_ns(host_s(first))};
    block.period_ps = std::llround(1e12 / rate_hz);
    for (int r = 0; r < kScansPerBlock; ++r)
      for (std::size_t c = 0; c < kChannels; ++c)
        block.counts[static_cast<std::size_t>(r)][c] =
            static_cast<std::int32_t>(std::lround(signal(host_s(first + r), c)));
    return block;
  }
  /// It is known that it has a clock, and nothing of it.
  ClockFit acquiring(double host_s) const {
    ClockFit none = fit(host_s);
    none.state = ClockState::kAcquire;
    return none;
  }
  ClockFit fit(double host_s, double error_s = 0.0) const {
    return {.node = 1,
            .epoch = epoch,
            .number = 1,
            .state = ClockState::kLocked,
            .host_ns = std::llround(1e9 * host_s),
            .node_ns = node_ns(host_s + error_s),
            .drift = drift};
  }
};

/// Largest difference, in counts, between rows and the truth at the instants of the grid.
inline double worst_error(const GridStream& stream, const Grid& grid) {
  double worst = 0.0;
  for (const GridRows& rows : stream.rows.at_hand())
    for (std::int64_t r = 0; r < rows.rows; ++r)
      for (std::size_t c = 0; c < kChannels; ++c) {
        const double time_s = 1e-9 * static_cast<double>(grid.time_ns(rows.first_index + r));
        worst = std::max(worst, std::abs(rows.counts[static_cast<std::size_t>(r)][c] - signal(time_s, c)));
      }
  return worst;
}

inline std::int64_t rows_in(const GridStream& stream) {
  std::int64_t sum = 0;
  for (const GridRows& rows : stream.rows.at_hand()) sum += rows.rows;
  return sum;
}

}  // namespace roadbalance::test
