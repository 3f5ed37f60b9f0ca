#pragma once

#include <complex>
#include <cstddef>

namespace roadbalance {

inline constexpr int kBinsOfLane = 8;
inline constexpr int kSegmentsOfBatch = 8;

/// Bins side by side: a line of the cache, and where one begins; one that lies across two costs twice.
struct alignas(64) BinLane {
  double of[kBinsOfLane] = {};
};

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

/// Real and imaginary parts of the lines apart, of each eight bins.
/// @param lanes  real parts of the first eight bins; the imaginary ones behind them; the next eight `step`
/// lanes on
void part_lines(const std::complex<double>* lines, std::size_t count, BinLane* lanes, std::size_t step);

/// One tile, which is eight bins of all channels: its pairs' sums, weighed by `before`, take up the segments
/// of a batch, each with its weight.
struct TileSums {
  const BinLane* lines;  ///< [segment][channel][re, im], `segment` lanes from one segment to the next
  BinLane* sum;          ///< [pair][re, im], rows of the upper triangle one after the other
  double before;
  double weight[kSegmentsOfBatch];  ///< 0 where none waits
  std::size_t channels;
  std::size_t segment;
};
void sum_up_tile(const TileSums& tile);

}  // namespace roadbalance
