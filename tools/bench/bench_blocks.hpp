#pragma once

#include <cstddef>
#include <cstdint>

#include "common/types/blocks.hpp"

namespace roadbalance::bench {

/// A block of 16 channels at 2 kHz whose counts do not repeat; its header is for the caller.
inline ScanBlock scans() {
  ScanBlock block;
  for (std::size_t row = 0; row < block.counts.size(); ++row)
    for (std::size_t c = 0; c < block.counts[row].size(); ++c)
      block.counts[row][c] = static_cast<std::int32_t>(7919 * row + 104'729 * c);
  block.period_ps = 500'000'000;
  return block;
}

}  // namespace roadbalance::bench
