#pragma once

#include <utility>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/identify/demodulation.hpp"
#include "host/identify/moments.hpp"
#include "host/identify/signals.hpp"

namespace roadbalance {

enum class RoadShare {
  kApart,   ///< each wheel for itself: S is taken for diagonal
  kShared,  ///< what wheels share of the road is cancelled
};

/// What the four wheels' road forces are like about the wheels' order, from the bins beside the lines.
///
/// They fall with the frequency squared and grow with speed, so at one order times speed they are alike at
/// all speeds of one road.
struct RoadSpectrum {
  Eigen::Matrix4cd sum = Eigen::Matrix4cd::Zero();  ///< of V F F^H over bins
  double bins = 0.0;

  RoadSpectrum& operator+=(const RoadSpectrum& other) {
    sum += other.sum;
    bins += other.bins;
    return *this;
  }
  /// The same mean as if from `most` bins, if there are more: what comes then counts against the past.
  RoadSpectrum remembering(double most) const {
    return bins > most ? RoadSpectrum{sum * (most / bins), most} : *this;
  }
};

/// Unbalance by windowed demodulation, with the road cancelled as far as the wheels share it.
///
/// The force that relation (1) leaves on wheel j is F_j = U_j Om_j^2 e^{j alpha_j} + ct_j u_j.  It is
/// demodulated with the angle of each wheel, which gives, with the taper's overlap c_jk of references j and
/// k,
///
///     y_jk = c_jk Om_j^2 U_j + n_jk,      E[n_jk conj(n_lm)] = S_jl K_km.
///
/// S, the cross-spectral matrix of the four road forces about the wheels' order, is measured from the bins
/// beside the lines, the rear ones advanced by wheelbase / V; K is the overlap of the references under the
/// squared taper.  Weighted least squares with S (x) K over all sections uses the rear wheels to cancel the
/// front wheels' road and the other way round, exactly as far as their measured coherence goes, and stays
/// right when wheels turn in step: their unbalances are unknowns of the same equations.
class HarmonicInstrument {
 public:
  HarmonicInstrument(const Geometry& geometry, Taper taper, double rate_hz, RoadShare share)
      : geometry_(geometry), demodulator_(std::move(taper), rate_hz), share_(share) {}

  /// @param signals     [kSignals x samples], a section of steady speed
  /// @param omega       rotation rate of each wheel, rad/s; 0: it has no reference here
  /// @param speed_m_s   of the car
  /// @param parameters  present knowledge, for the weights only
  RoadSpectrum road(const Eigen::Ref<const SignalMatrix>& signals, const Eigen::Vector4d& omega,
                    double speed_m_s, const ParameterVector& parameters) const;

  /// @param road  for the weights: of this section and such as are like it
  HarmonicMoments moments(const Eigen::Ref<const SignalMatrix>& signals, const Eigen::Vector4d& omega,
                          double speed_m_s, const ParameterVector& parameters,
                          const RoadSpectrum& road) const;

 private:
  Geometry geometry_;
  Demodulator demodulator_;
  RoadShare share_;
};

}  // namespace roadbalance
