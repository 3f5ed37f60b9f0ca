#pragma once

#include <complex>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace roadbalance {

/// Motion of one point of the car at one speed, at the first order of the wheels.
struct ResponsePoint {
  std::complex<double> measured;  ///< R_sp, of all causes together, m/s^2
  Eigen::VectorXcd per_force;     ///< [wheel] H_spw, per unit of force on that wheel, m/s^2 per N
  Eigen::VectorXd omega;          ///< [wheel] Om_sw, rotation rate, rad/s
  double weight = 1.0;            ///< k_sp: of the speed and of the place, the seat for one; > 0
};

struct OverallCompensation {
  Eigen::VectorXcd correction_kg_m;          ///< [wheel] x_w, mass times radius at its angle
  Eigen::VectorXcd residual;                 ///< [point] what is left, m/s^2
  double rms_before = 0.0, rms_after = 0.0;  ///< weighted, sqrt(sum k |R|^2 / sum k)
};

/// Weights that quieten all points at all speeds as well as weights can, whatever the cause,
///
///     min_x sum k_sp |R_sp + sum_w H_spw Om_sw^2 x_w|^2,   x = -(A^H K A)^-1 A^H K R,  A = H Om^2.
///
/// The part that grows with speed squared goes; the rest (radial force variation) goes as far as it can over
/// the speeds chosen, and the residual is the part that stays.  The weight opposite to an unbalance is the
/// case without other causes.  Responses come from the identified model or from trial weights
/// (balance_by_influence).
///
/// @throws std::invalid_argument if points differ in their wheels or a weight is not positive
/// @return nothing if the points do not determine the weights
std::optional<OverallCompensation> compensate_overall(const std::vector<ResponsePoint>& points);

}  // namespace roadbalance
