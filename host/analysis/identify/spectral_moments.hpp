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

  /// Settled so long after the first sample: e^-7.
  static constexpr double kSettling_s = 4.0;

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

/// Makes SpectralMoments of stretches of samples.
class SpectralGatherer {
 public:
  SpectralGatherer(Eigen::Index channels, double wheelbase_m, double rate_hz);

  /// Segments evenly over the whole, but for those with a sample that is not quiet.
  /// @param motion      [3 m + n x samples] of MotionIntegrals, settled, at a steady speed
  /// @param distance_m  [sample] along the road
  /// @param quiet       [sample] 0: not to be used
  /// @param omega       rotation rate of each wheel, rad/s; 0: it has no line
  SpectralMoments moments(const Eigen::Ref<const Eigen::MatrixXd>& motion,
                          const Eigen::Ref<const Eigen::ArrayXd>& distance_m,
                          const Eigen::Ref<const Eigen::ArrayXd>& quiet, const Eigen::Vector4d& omega);

 private:
  void add_segment(SpectralMoments& sum, const Eigen::Ref<const Eigen::MatrixXd>& motion,
                   const std::vector<bool>& masked, double weight, double delay_s);

  Eigen::Index channels_;
  double wheelbase_m_;
  double rate_hz_;
  RealFft fft_;
  Eigen::ArrayXd window_;  ///< its squares' sum is the rate: a periodogram is a density
};

}  // namespace roadbalance
