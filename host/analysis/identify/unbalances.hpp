#pragma once

#include <bitset>

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/moments.hpp"

namespace roadbalance {

/// Unbalance phasors of the four wheels, kg m, by the angle references: linear in the tyres'
/// stiffnesses,
///
///     U = U_0 + sum_j u_j ct_j,    N U = sum_j force of right[.][j] on wheel j's row.
struct Unbalances {
  Eigen::Vector4cd without_tyres;  ///< U_0
  Eigen::Matrix4cd per_tyre;       ///< column j: u_j
  /// E[dU dU^H] of the road's noise, circular: half of it on either axis.
  Eigen::Matrix4cd covariance;
  std::bitset<kWheels> found;  ///< wheels that have equations; the rest is 0 in all of the above

  Eigen::Vector4cd at(const Eigen::Vector4d& tyre_n_m) const {
    return without_tyres + per_tyre * tyre_n_m.cast<std::complex<double>>();
  }
};

/// @param without_tyres  the car, its tyres' stiffnesses 0
/// @param asked          wheels that may be out of balance
Unbalances solve_unbalances(const HarmonicMoments& moments, const Geometry& geometry,
                            const ParameterVector& without_tyres,
                            const std::bitset<kWheels>& asked = std::bitset<kWheels>().set());

/// The model of one parameter alone: every matrix is linear in every parameter.
LinearModel unit_model(const Geometry& geometry, int parameter);

/// Inverse of N over the wheels that have equations, zero elsewhere.
Eigen::Matrix4cd inverse_where_known(const Eigen::Matrix4cd& normal);

}  // namespace roadbalance
