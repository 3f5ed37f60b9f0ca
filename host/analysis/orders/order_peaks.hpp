#pragma once

#include <vector>

#include "host/analysis/orders/order_waterfall.hpp"

namespace roadbalance {

struct OrderPeak {
  double order;
  double amplitude;
};

/// Lines that stand out of an order spectrum, the highest first.
///
/// A peak is higher than every line within the window's width (5 steps) on either side, and kPeakAbove times
/// as high as the lines fall to in the kPeakValley steps beyond - a resonance that the road excites is wider
/// - and as the median of the lines within kPeakNeighbourhood orders: of a single block's noise, which is
/// Rayleigh distributed, the highest of 150 lines is 2.7 medians.  The order is the mean of the peak's lines
/// by their power, which is exact for a line that stands free.  Lines within the window's width of order 0
/// are the mean value.  Lines below kPeakLeast of the highest peak may be left by the resampling of that
/// peak.
///
/// @param most  peaks
std::vector<OrderPeak> find_peaks(const OrderSpectrum& spectrum, std::size_t most);
inline constexpr double kPeakAbove = 3.0;
inline constexpr std::size_t kPeakValley = 4;
inline constexpr double kPeakLeast = 3e-4;
inline constexpr double kPeakNeighbourhood = 2.0;

}  // namespace roadbalance
