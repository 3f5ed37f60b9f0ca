#pragma once

#include <vector>

#include <Eigen/Core>

namespace roadbalance {

/// Cross-spectral matrices over bins of frequency, gathered at about one speed; they add.
///
/// Signals are the vertical channels' accelerations y [m], their velocities and their displacements,
/// integrated before the window is laid on them, so that an equation of motion holds within it: x = [y; y';
/// y''-integrals], 3 m rows.  Sums over tapered segments of x x^H, and of the same as the rear wheels would
/// have seen it on the front wheels' road: e^{-j om L/V} x x^H, with each segment's own speed.
struct SpectralMoments {
  double step_hz = 0.0;  ///< distance of the bins, the first of which is first * step_hz; 0: nothing yet
  Eigen::Index first = 0;
  double segments = 0.0;                  ///< their weights' sum
  double delay_seconds = 0.0;             ///< their sum of wheelbase / V
  Eigen::ArrayXd count;                   ///< [bin] independent segments in it
  std::vector<Eigen::MatrixXcd> same;     ///< [bin] 3 m x 3 m
  std::vector<Eigen::MatrixXcd> delayed;  ///< [bin] rows of front wheels against columns of rear ones count

  SpectralMoments& operator+=(const SpectralMoments& other);

  Eigen::Index bins() const { return count.size(); }
  double omega(Eigen::Index bin) const;  ///< circular frequency, rad/s
  double delay_s() const { return delay_seconds / segments; }
};

}  // namespace roadbalance
