#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/types/blocks.hpp"

namespace roadbalance {

/// The instants that all nodes' samples are brought to: origin + index * period, in the host's time.
struct Grid {
  std::optional<std::int64_t> origin_ns;  ///< of the first sample that came
  std::int64_t period_ps = 0;

  /// Position of an instant, in periods since the origin.
  double position(std::int64_t time_ns) const {
    return static_cast<double>(time_ns - *origin_ns) * 1000.0 / static_cast<double>(period_ps);
  }
  std::int64_t time_ns(std::int64_t index) const {
    return *origin_ns + (index / 1000) * period_ps + (index % 1000) * period_ps / 1000;
  }
};

/// Consecutive rows of one node on the grid.  Counts of 24 bits are exact as float.
struct GridRows {
  static constexpr std::size_t kMost = kScansPerBlock;

  std::int64_t first_index = 0;
  std::int64_t rows = 0;
  std::int64_t time_ns =
      0;                 ///< of the first row: the node's where its samples are the grid's, else the host's
  bool restart = false;  ///< the first row does not go on from the one before, whatever its index
  std::int32_t overload = 0;  ///< of any sample that a row was made of; see ClippedChannels
  std::int32_t quality = 0;   ///< the same
  std::array<std::array<float, kChannels>, kMost> counts;  ///< [row][channel]
};

}  // namespace roadbalance
