#pragma once

#include <array>
#include <utility>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/demodulation.hpp"
#include "host/analysis/identify/moments.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {

enum class RoadShare {
  kApart,   ///< each wheel for itself: S is taken for diagonal
  kShared,  ///< what wheels share of the road is cancelled
};

/// Effect of the road on the car about the wheels' order, from the bins beside the lines.
///
/// The wheels' road forces F fall with the frequency squared and grow with speed, so at one order V F F^H is
/// alike at all speeds of one road.  Kept is what it is made of, so that it can be had for any parameters of
/// the car: the products of what stands with M, P and Q, undelayed for the front wheels and as the rear ones
/// would have felt it on the front wheels' road.
struct RoadSpectrum {
  static constexpr int kRows = 2 * 3 * kCoordinates;
  using Products = Eigen::Matrix<std::complex<double>, kRows, kRows>;
  /// Sum of V w w^H over bins, w = [v; v e^{j x L/V}], v what one bin has for M, P and Q (InstrumentMoments),
  /// x its distance from the line in rad/s.
  Products sum = Products::Zero();
  double bins = 0.0;

  /// Sum of V F F^H over bins.
  Eigen::Matrix4cd forces(const LinearModel& model) const;

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

/// A section at its wheels' lines, whatever it is weighed by.
struct SectionLines : DemodulatedLines {
  Eigen::Vector4d omega = Eigen::Vector4d::Zero();  ///< rotation rate of each wheel, rad/s
  double speed_m_s = 0.0;
};

/// A section at its wheels' lines and beside them.
struct HarmonicReading {
  SectionLines lines;
  RoadSpectrum road;
  Eigen::MatrixXcd readings{};  ///< [reference x channel] phasors of what else was given
  double effective_s = 0.0;     ///< Demodulated's
  double seconds = 0.0;         ///< quiet ones

  /// `road` for one second of even window: what sections of any length and window share.
  RoadSpectrum density() const;
  /// What this section's window makes of such a density.
  RoadSpectrum road_of(const RoadSpectrum& density) const;
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
///
/// Weights of these least squares.
struct LineWeights {
  Eigen::Matrix4cd normal = Eigen::Matrix4cd::Zero();  ///< of the unbalances
  /// [unknown wheel] what its equation takes of the force on wheel j (row) at reference k (column).
  std::array<Eigen::Matrix4cd, kWheels> weight{};
};

/// @param lines       a section's
/// @param parameters  present knowledge, for the weights only
/// @param road        for the weights: of this section and such as are like it
/// All 0 where nothing shakes the car, or the road shows too few bins.
LineWeights line_weights(const SectionLines& lines, const Geometry& geometry,
                         const ParameterVector& parameters, const RoadSpectrum& road, RoadShare share);

/// With line_weights, of the phasors of z''.
HarmonicMoments harmonic_moments(const SectionLines& lines, const Geometry& geometry,
                                 const ParameterVector& parameters, const RoadSpectrum& road,
                                 RoadShare share);

/// Takes from sections of one length what harmonic_moments is made of.
class HarmonicInstrument {
 public:
  HarmonicInstrument(const Geometry& geometry, Taper taper, double rate_hz)
      : wheelbase_m_(geometry.x_m[0] - geometry.x_m[2]),
        rate_hz_(rate_hz),
        demodulator_(std::move(taper), rate_hz) {}

  /// @param signals    [kSignals x samples], a section of steady speed
  /// @param omega      rotation rate of each wheel, rad/s; 0: it has no reference here
  /// @param speed_m_s  of the car
  HarmonicReading read(const Eigen::Ref<const SignalMatrix>& signals, const Eigen::Vector4d& omega,
                       double speed_m_s) const;
  /// @param readings   [channel x samples] of the same filters
  /// @param quiet      [sample] factor of the taper
  HarmonicReading read(const Eigen::Ref<const SignalMatrix>& signals, const Eigen::Vector4d& omega,
                       double speed_m_s, const Eigen::Ref<const Eigen::MatrixXd>& readings,
                       const Eigen::Ref<const Eigen::ArrayXd>& quiet) const;

 private:
  double wheelbase_m_, rate_hz_;
  Demodulator demodulator_;
};

}  // namespace roadbalance
