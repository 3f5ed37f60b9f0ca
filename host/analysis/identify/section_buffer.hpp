#pragma once

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Core>

#include "common/dsp/state_filter.hpp"
#include "common/dsp/taper.hpp"
#include "host/analysis/identify/harmonic.hpp"
#include "host/analysis/identify/moments.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {

/// Whole samples in so many seconds, at least one.
inline Eigen::Index samples_in(double seconds, double rate_hz) {
  return std::max<Eigen::Index>(1, std::lround(seconds * rate_hz));
}

/// The section of a drive that is being filled, with the filtered accelerations that are its instruments.
///
/// Every section is closed by a C2 taper on its instruments, so that (2) holds for the finite section without
/// end terms.  Instruments are those of instruments.hpp.  Their lags are positive (instrument past,
/// acceleration future): the road to come and sensor noise then drop out.
/// A section that follows another begins in its last second, where one taper falls as the other rises: their
/// sum is 1, and nothing of a drive counts less.
class SectionBuffer {
 public:
  /// @param samples  of a section
  SectionBuffer(const Geometry& geometry, double rate_hz, Eigen::Index samples);

  /// Samples beyond `samples` that a section needs for its longest lag.
  static Eigen::Index lag(double rate_hz);
  /// Samples that a section has in common with the one before it.
  static Eigen::Index overlap(double rate_hz, Eigen::Index samples);

  /// Samples are missing: holds nothing, filters begin anew.
  void reset();
  /// Runs the filters only.
  void settle(const SignalVector& sample);
  /// The next sample; not when full.
  void push(const SignalVector& sample);
  /// Keeps the newest `count` samples as the beginning of the next section.
  void keep(Eigen::Index count);

  Eigen::Index filled() const { return filled_; }
  bool full() const { return filled_ == signals_.cols(); }
  /// Samples of a full one that the next section keeps.
  Eigen::Index shared() const { return overlap_ + filled_ - taper_.value.size(); }
  /// [signal x sample] so far.
  auto signals() const { return signals_.leftCols(filled_); }
  /// The signals of a full one, without its lag.
  auto section() const { return signals_.leftCols(taper_.value.size()); }
  const Taper& taper() const { return taper_; }
  /// Seconds of driving that a section of `samples` counts for.
  double seconds(Eigen::Index samples) const { return static_cast<double>(samples - overlap_) / rate_hz_; }

  /// True if its first `samples` and their lag are there: then there are moments of them.
  bool holds(Eigen::Index samples) const { return filled_ >= samples + lag(rate_hz_); }

  /// From the first `samples`.
  /// @param omega      rotation rate of each wheel, rad/s; 0: it has no reference here
  /// @param speed_m_s  of the car
  /// @param readings   [channel x samples] of the same filters
  /// @param quiet      [sample] 0 where something else than the road shakes the car
  HarmonicReading harmonic(Eigen::Index samples, const Eigen::Vector4d& omega, double speed_m_s,
                           const Eigen::Ref<const Eigen::MatrixXd>& readings,
                           const Eigen::Ref<const Eigen::ArrayXd>& quiet);
  HarmonicReading harmonic(Eigen::Index samples, const Eigen::Vector4d& omega, double speed_m_s) {
    return harmonic(samples, omega, speed_m_s, Eigen::MatrixXd(0, samples), Eigen::ArrayXd::Ones(samples));
  }
  /// All but DriveMoments::harmonic, which harmonic_moments makes of the reading.
  DriveMoments moments(Eigen::Index samples, const Eigen::Vector4d& omega, double speed_m_s);
  /// From the first `samples`.
  const Taper& taper(Eigen::Index samples) { return window(samples).taper; }

 private:
  /// Values that depend on a section's length.
  struct Window {
    Taper taper;
    HarmonicInstrument harmonic;
  };
  const Window& window(Eigen::Index samples);
  void add_chassis(DriveMoments& sum, const Taper& taper) const;
  void add_tyre(DriveMoments& sum, const Taper& taper, int wheel, double omega) const;

  double rate_hz_;
  Eigen::Index chassis_lag_, tyre_lag_, overlap_;
  StateFilter chassis_filter_, tyre_filter_;
  Taper taper_;
  Geometry geometry_;
  std::map<Eigen::Index, Window> windows_;  ///< by samples; made when they are first needed
  SignalMatrix signals_;                    ///< [signal x sample], a section and the longest lag
  Eigen::MatrixXd chassis_states_;          ///< [coordinate + 7 * state x sample]
  Eigen::MatrixXd tyre_states_;             ///< [wheel + 4 * state x sample]
  Eigen::Index filled_ = 0;
};

}  // namespace roadbalance
