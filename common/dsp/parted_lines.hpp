#pragma once

#include <complex>
#include <cstddef>

namespace roadbalance {

inline constexpr int kBinsOfLane = 8;

/// Bins side by side: a line of the cache, and where one begins; one that lies across two costs twice.
struct alignas(64) BinLane {
  double of[kBinsOfLane] = {};
};

/// Real and imaginary parts of a transform's lines apart: the real parts of the first eight bins, their
/// imaginary parts, the next eight.
/// @param lanes  [2 ceil(count / 8)], of the last two only the places of lines
void part_lines(const std::complex<double>* lines, std::size_t count, BinLane* lanes);

inline constexpr int kPairsTogether = 16;  ///< lines k and M - k of two whole lanes

/// The lines X of N = 2 M real samples, parted as part_lines() does, from the transform Z of the same samples
/// taken two by two as M complex numbers, which costs less than a transform of real ones: with u[k] = -j/2
/// exp(-2 pi j k / N)
///
///     X[k] = (Z[k] + conj Z[M - k]) / 2 + u[k] (Z[k] - conj Z[M - k]),   k = 0 .. M,   Z[M] = Z[0]
///
/// Source: W. H. Press et al., Numerical Recipes, 3rd ed., 2007, sec. 12.3.2.
///
/// @param z      [M + 1] Z as pairs of doubles, and room for one more, which is written
/// @param turn   [M / 8] u[0 .. M / 2 - 1], parted as the lines
/// @param pairs  M, a multiple of kPairsTogether
/// @param lanes  [2 (M / 8 + 1)]
void untangle_pairs(double* z, const BinLane* turn, std::size_t pairs, BinLane* lanes);

}  // namespace roadbalance
