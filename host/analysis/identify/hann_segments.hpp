#pragma once

#include <vector>

#include <Eigen/Core>

namespace roadbalance {

/// Hann-tapered segments evenly over samples.  They overlap, and each weighs as many independent bins as it
/// brings.
struct HannSegments {
  std::vector<Eigen::Index> begin;
  double weight = 0.0;  ///< of each

  /// Fewer samples than one segment: none.
  static HannSegments over(Eigen::Index samples, Eigen::Index size);
};

/// Segments this share of their length apart use 99.9 % of what a record holds; half apart, 95 %.
inline constexpr double kHannHop = 0.375;
/// Independent bins in a bin of one segment: one over the sum of the squared correlations of bins.  A segment
/// kHannHop behind another brings kHannHop more.
inline constexpr double kHannAlone = 18.0 / 35.0;

/// Half width of a wheel's line in bins: the Hann window's main lobe and a bit.
inline constexpr double kLineBins = 2.6;

/// Orders of a wheel's turning in which its tyre pushes harder than a road of that coherence would: taken for
/// road, 60 N in orders 2 and 3 make tyres 4 % and wheels' masses 3 % wrong.
inline constexpr int kForceOrders = 3;

/// Bins from the first on in which some wheel's line of its first kForceOrders orders lies.
/// @param omega  rotation rate of each wheel, rad/s; 0: it has no lines
std::vector<bool> bins_with_lines(std::size_t bins, Eigen::Index first, double step_hz,
                                  const Eigen::Vector4d& omega);

}  // namespace roadbalance
