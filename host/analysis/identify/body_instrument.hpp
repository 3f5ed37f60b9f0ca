#pragma once

#include <array>
#include <utility>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/demodulation.hpp"
#include "host/analysis/identify/moments.hpp"

namespace roadbalance {

/// Unbalance from the body's accelerations alone, where no sensor sits on the wheel carriers.
///
/// Nothing of the car can be identified then: the way from a wheel to the body is that of vehicle.toml,
/// z'' = G_i(j Om_i) U_i e^{j alpha_i}, with G_i = -Om^4 (Q + j Om P - Om^2 M)^-1 W_i.  Demodulated with the
/// angle of each wheel,
///
///     y_k = sum_i c_ik G_i U_i + n_k,      E[n_k n_l^H] = S K_kl,
///
/// S the spectral matrix of the body's own shaking beside the line, by weighted least squares.  Wheels that
/// turn in step differ in G alone, which trusts a rigid body: DriveEstimator refuses them.
class BodyInstrument {
 public:
  /// @param taper  of a section; its length is the section's
  BodyInstrument(const VehicleConfig& vehicle, Taper taper, double rate_hz)
      : model_(linear_model(geometry_of(vehicle.model), nominal_parameters(vehicle))),
        demodulator_(std::move(taper), rate_hz) {}

  /// @param signals  [kSignals x samples], a section of steady speed
  /// @param omega    rotation rate of each wheel, rad/s; 0: it has no reference here
  BodyMoments moments(const Eigen::Ref<const SignalMatrix>& signals, const Eigen::Vector4d& omega) const;

 private:
  LinearModel model_;
  Demodulator demodulator_;
};

/// Accuracy of the springs, dampers, stabilisers and tyres of vehicle.toml, one standard deviation.
inline constexpr double kParameterSigma = 0.1;

/// Variance of the relative error that this leaves in the unbalance of one wheel at `omega`.
struct ResponseVariance {
  double along = 0.0;   ///< of the magnitude
  double across = 0.0;  ///< of the angle, rad^2
};
std::array<ResponseVariance, kWheels> response_variance(const VehicleConfig& vehicle, double speed_m_s);

}  // namespace roadbalance
