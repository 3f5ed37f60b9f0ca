#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/dsp/fft.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/hann_segments.hpp"
#include "host/analysis/identify/signals.hpp"
#include "host/analysis/identify/speed_spectra.hpp"

namespace roadbalance {

/// Bins that the Whittle likelihood looks at: above the body's modes, below the tyre's belt.
inline constexpr double kWhittleFrom_hz = 3.0;
inline constexpr double kWhittleTo_hz = 40.0;
inline constexpr double kWhittleSegment_s = 4.0;

/// Of z''.
using WhittleMoments = SpeedSpectra<Eigen::Matrix<std::complex<double>, kCoordinates, kCoordinates>>;

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
  Eigen::Index first_ = 0;    ///< of the transform's bins
  std::vector<bool> masked_;  ///< [bin] of the present stretch
  double weight_ = 0.0;       ///< of its segments
};

}  // namespace roadbalance
