#pragma once

#include <complex>

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"

namespace roadbalance {

/// Phasors of z'' per 1 kg m of unbalance of a wheel that turns at omega, m/s^2:
/// G = -Om^2 (Q + j Om P - Om^2 M)^-1 W Om^2, by (1).
///
/// @param omega  > 0, rad/s
Eigen::Matrix<std::complex<double>, kCoordinates, 1> unbalance_response(const LinearModel& model, int wheel,
                                                                        double omega);

}  // namespace roadbalance
