#pragma once

#include <array>
#include <complex>
#include <vector>

#include <Eigen/Core>

#include "host/analysis/identify/hann_segments.hpp"
#include "host/analysis/identify/signals.hpp"
#include "host/analysis/identify/spectral_moments.hpp"
#include "host/analysis/identify/strut_motion.hpp"

namespace roadbalance {

/// The vertical channels' readings, and what the struts and the integrals make of them, over the section that
/// is being driven and as much before it as a segment of spectra reaches back.
///
/// Segments follow each other by kHannHop, from section to section at one speed, so that nothing of the drive
/// counts less.
class MotionBuffer {
 public:
  /// @param sensors  [channel x 7] reading of each vertical channel per unit of z''
  /// @param samples  of the longest section with its lag
  MotionBuffer(const Geometry& geometry, const Eigen::MatrixXd& sensors, double rate_hz,
               Eigen::Index samples);

  Eigen::Index channels() const { return channels_; }
  /// Samples are missing: holds nothing, filters begin anew.
  void reset();
  /// Runs the filters only.
  void settle(const Eigen::Ref<const Eigen::VectorXd>& readings);
  /// The next sample.
  void push(const Eigen::Ref<const Eigen::VectorXd>& readings, const SignalVector& signals);
  /// Begins anew with the newest `count` samples: another speed.
  void keep(Eigen::Index count);
  /// The next section, which begins with the newest `shared` samples, goes on at this speed; what came before
  /// was taken.
  void go_on(Eigen::Index shared);

  /// Of the `count` samples that end `behind` samples before the newest:
  /// readings of the channels, and behind them the struts' signals [channel + kStrutSignals x sample].
  auto readings(Eigen::Index count, Eigen::Index behind) const {
    return readings_.middleCols(filled_ - behind - count, count);
  }
  /// quiet_samples of all that is there before the newest `behind`.
  Eigen::ArrayXd quiet(Eigen::Index behind) const;

  /// Spectra of the segments that end by then and were not taken yet, those that are quiet and settled all
  /// through.
  /// @param quiet             as quiet(behind) has it
  /// @param omega             rotation rate of each wheel, rad/s; 0: it has no reference
  /// @param timer             the wheel whose turning gives the speed
  /// @param rolling_radius_m  of it
  SpectralMoments take(const Eigen::ArrayXd& quiet, const Eigen::Vector4d& omega, int timer,
                       double rolling_radius_m);

 private:
  void drop(Eigen::Index count);

  double rate_hz_;
  Eigen::Index channels_;
  std::vector<Eigen::Index> carriers_;  ///< channels on the wheels' carriers
  StrutMotion struts_;
  MotionIntegrals integrals_;
  SpectralGatherer gatherer_;
  Eigen::Index hop_;
  Eigen::Index settling_ = 0;  ///< samples until the filters have settled
  Eigen::VectorXd with_struts_, moved_;
  Eigen::MatrixXd readings_;                                  ///< [channel + kStrutSignals x sample]
  Eigen::MatrixXd motion_;                                    ///< [motion x sample]
  Eigen::Array<double, kWheels, Eigen::Dynamic> turned_rad_;  ///< since the sample before; 0: no reference
  Eigen::ArrayXd settled_;                                    ///< [sample] 1: it is
  std::array<std::complex<double>, kWheels> before_{};        ///< references
  Eigen::Index filled_ = 0;
  Eigen::Index next_ = 0;  ///< where the next segment begins
  bool first_ = true;      ///< at this speed
};

}  // namespace roadbalance
