#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/dsp/fft.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/speed_spectra.hpp"

namespace roadbalance {

/// Of motion, 3 m + n rows: accelerations of m vertical channels, their velocities and displacements, and n
/// further signals (MotionIntegrals).  Two-sided densities times their count, (m/s^2)^2 / Hz among
/// accelerations.
using SpectralMoments = SpeedSpectra<Eigen::MatrixXcd>;

/// Accelerations, velocities and displacements of channels, and further signals as they are, all behind one
/// high-pass of third order at 0.35 Hz. They are integrated before a window is laid on them, so that an
/// equation of motion holds within it.
class MotionIntegrals {
 public:
  MotionIntegrals(Eigen::Index channels, Eigen::Index further, double rate_hz);

  /// The next sample.  Never allocates.
  /// @param signals  [channels + further] m/s^2 of the channels
  /// @param motion   [3 channels + further] m/s^2, m/s, m, and as they are
  void update(const Eigen::Ref<const Eigen::ArrayXd>& signals, Eigen::Ref<Eigen::ArrayXd> motion);
  void reset() { filter_.reset(); }

 private:
  Eigen::Index channels_;
  Eigen::Array3d denominator_;
  StateFilter filter_;
};

/// Makes SpectralMoments of segments of samples.
///
/// Their bins are lines of the transform up to 4 Hz, and hold 2, 4, 8 .. lines in each octave above: what is
/// the same in a bin is the road's shape and the tyres' stiffness, for the motion's integrals and the rear
/// wheels' delay are those of each line.
class SpectralGatherer {
 public:
  SpectralGatherer(Eigen::Index channels, double wheelbase_m, double rate_hz);

  /// Samples of a segment.
  Eigen::Index size() const { return fft_.size(); }
  /// @param motion     [3 m + n x size()] of MotionIntegrals, settled, at a steady speed
  /// @param weight     independent lines that a line of it brings (HannSegments)
  /// @param omega      rotation rate of each wheel, rad/s; 0: it has no line
  void add(SpectralMoments& sum, const Eigen::Ref<const Eigen::MatrixXd>& motion, double weight,
           const Eigen::Vector4d& omega, double speed_m_s);

 private:
  Eigen::MatrixXcd transformed(const Eigen::Ref<const Eigen::MatrixXd>& motion);

  Eigen::Index channels_;
  double wheelbase_m_;
  double rate_hz_;
  RealFft fft_;
  Eigen::ArrayXd window_;          ///< its squares' sum is the rate: a periodogram is a density
  Eigen::Index first_;             ///< of the transform's lines
  std::vector<Eigen::Index> bin_;  ///< [line from the first]
  Eigen::ArrayXd frequency_hz_;    ///< [bin] mean of its lines
};

}  // namespace roadbalance
