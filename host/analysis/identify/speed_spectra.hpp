#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/types/angle_units.hpp"

namespace roadbalance {

/// Cross-spectral matrices of signals over bins of frequency, gathered at about one speed; they add.
///
/// Sums over Hann-tapered segments of X X^H, and of the same as the rear wheels would have seen it on the
/// front wheels' road: e^{-j om L/V} X X^H, with each segment's own speed.  Segments in which a wheel's line
/// of its first kForceOrders orders lies within kLineBins of a bin do not count there.  Segments overlap; each weighs as many independent bins
/// as it brings (HannSegments).
template <typename Matrix>
struct SpeedSpectra {
  using Spectra = std::vector<Matrix>;
  Eigen::ArrayXd frequency_hz;  ///< [bin]
  double segments = 0.0;        ///< their weights' sum; 0: nothing yet
  double delay_seconds = 0.0;   ///< their sum of wheelbase / V
  Eigen::ArrayXd count;         ///< [bin] segments in it
  Spectra same;                 ///< [bin] of both wheels of an axle
  Spectra delayed;              ///< [bin] rows of front wheels against columns of rear ones

  SpeedSpectra& operator+=(const SpeedSpectra& other) {
    if (other.segments == 0.0) return *this;
    if (segments == 0.0) return *this = other;
    delay_seconds += other.delay_seconds;
    segments += other.segments;
    count += other.count;
    for (std::size_t k = 0; k < same.size(); ++k) {
      same[k] += other.same[k];
      delayed[k] += other.delayed[k];
    }
    return *this;
  }

  Eigen::Index bins() const { return count.size(); }
  /// Of a bin, circular frequency in rad/s.
  double omega(Eigen::Index bin) const { return kTurn * frequency_hz(bin); }
  double delay_s() const { return delay_seconds / segments; }
};

}  // namespace roadbalance
