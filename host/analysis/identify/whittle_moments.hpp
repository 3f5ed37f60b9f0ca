#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/dsp/fft.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {

/// Bins that the Whittle likelihood looks at: above the body's modes, below the tyre's belt.
inline constexpr double kWhittleFrom_hz = 3.0;
inline constexpr double kWhittleTo_hz = 40.0;
inline constexpr double kWhittleSegment_s = 4.0;

/// Cross-spectral matrices of z'' over the bins, gathered at about one speed; they add.
///
/// Sums over Hann-tapered segments of Z Z^H, and of the same as the rear wheels would have seen it on the
/// front wheels' road: e^{-j om L/V} Z Z^H, with each segment's own speed.  Segments in which a wheel's line
/// lies within 2.6 bins of a bin do not count there.  Segments overlap; each weighs as many independent bins
/// as it brings.
struct WhittleMoments {
  using Spectra = std::vector<Eigen::Matrix<std::complex<double>, kCoordinates, kCoordinates>>;
  double step_hz = 0.0;  ///< distance of the bins, the first of which is first * step_hz; 0: nothing yet
  Eigen::Index first = 0;
  double segments = 0.0;       ///< their weights' sum
  double delay_seconds = 0.0;  ///< their sum of wheelbase / V
  Eigen::ArrayXd count;        ///< [bin] segments in it
  Spectra same;                ///< [bin] of both wheels of an axle
  Spectra delayed;             ///< [bin] rows of front wheels against columns of rear ones

  WhittleMoments& operator+=(const WhittleMoments& other);

  double omega(Eigen::Index bin) const;  ///< of one of `count`, circular frequency in rad/s
};

/// Makes WhittleMoments of stretches of samples.
class WhittleGatherer {
 public:
  WhittleGatherer(const Geometry& geometry, double rate_hz);

  /// Segments evenly over the whole; fewer samples than one segment: nothing.
  /// @param signals    [kSignals x samples] at a steady speed
  /// @param omega      rotation rate of each wheel, rad/s; 0: it has no line
  /// @param speed_m_s  of the car
  WhittleMoments moments(const Eigen::Ref<const SignalMatrix>& signals, const Eigen::Vector4d& omega,
                         double speed_m_s);

 private:
  void add_segment(WhittleMoments& sum, const Eigen::Ref<const SignalMatrix>& signals, double delay_s);

  double wheelbase_m_;
  double rate_hz_;
  RealFft fft_;
  Eigen::ArrayXd window_;
  std::vector<bool> masked_;  ///< [bin] of the present stretch
  double weight_ = 0.0;       ///< of its segments
};

}  // namespace roadbalance
