#pragma once

#include <cstddef>

#include "common/dsp/parted_lines.hpp"

namespace roadbalance {

inline constexpr int kSegmentsOfBatch = 8;

/// Samples as they come to signals of their own: out[c][n] = window[n] (in[n][c] - mean[c]).
struct Tapering {
  const double* in;        ///< [sample][channel]
  std::size_t channels;    ///< from one sample of `in` to the next
  std::size_t first, end;  ///< of the channels, those to be done
  const double* window;    ///< [sample]
  std::size_t samples;
  const double* mean;  ///< [channel]
  double* out;         ///< [channel - first][sample]
  std::size_t column;  ///< from one channel of `out` to the next
};
void taper_columns(const Tapering& work);

/// One tile, which is eight bins of all channels: its pairs' sums, weighed by `before`, take up the segments
/// of a batch, each with its weight.
struct TileSums {
  const BinLane* lines;          ///< of the tile, [re, im] of the first channel and segment
  std::size_t channel, segment;  ///< lanes from one channel to the next, from one segment to the next
  BinLane* sum;                  ///< [pair][re, im], rows of the upper triangle one after the other
  double before;
  double weight[kSegmentsOfBatch];  ///< 0 where none waits
  std::size_t channels;
};
void sum_up_tile(const TileSums& tile);

}  // namespace roadbalance
