#pragma once

#include <Eigen/Core>

#include "common/dsp/state_filter.hpp"
#include "common/vehicle/linear_model.hpp"

namespace roadbalance {

/// Beyond a linear damper, of each strut: dry friction tanh(v / v0), and |v|, which a damper has that is
/// harder one way than the other.
inline constexpr int kStrutSignals = 2 * kWheels;

/// Stretch rates v of the four struts, positive in rebound, as a body and wheels move [4 x 7].
Eigen::Matrix<double, kWheels, kCoordinates> strut_stretch(const Geometry& geometry);

/// Computes these signals from the vertical channels.
///
/// The rate is the stretch's acceleration a behind
///
///     s (s + 2 w) / (s^3 + 2 w s^2 + 2 w^2 s + w^3),   w = 2 pi 0.1 Hz,
///
/// which takes what is constant off and leads by 3 (w / om)^3 only.  A plain high-pass of second order leads by
/// 1.4 w / om, 0.14 rad where the body moves most: 100 N of friction then seem a spring of 2 kN/m.
class StrutMotion {
 public:
  /// @param stretch  [4 x channel] of strut_stretch by the channels' accelerations
  StrutMotion(const Eigen::Ref<const Eigen::MatrixXd>& stretch, double rate_hz);

  /// Settled so long after the first sample.
  static constexpr double kSettling_s = 8.0;
  /// Below it dry friction is viscous.
  static constexpr double kSmooth_m_s = 5e-3;

  /// The next sample.
  /// @param acceleration  [channel] m/s^2
  /// @param signals       [kStrutSignals] 1, then m/s
  void update(const Eigen::Ref<const Eigen::ArrayXd>& acceleration, Eigen::Ref<Eigen::ArrayXd> signals);
  void reset() { velocity_.reset(); }

 private:
  Eigen::MatrixXd stretch_;
  StateFilter velocity_;
};

}  // namespace roadbalance
