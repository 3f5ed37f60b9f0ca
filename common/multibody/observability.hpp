#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/multibody/affine_model.hpp"

namespace roadbalance {

/// How much of the unbalances of one rotor sensors show, all parameters known.
///
/// A unit unbalance in plane p answers at the rate Om with the phasors
///
///     h_p(Om) = (tilt - Om^2 acceleration) (Q + j Om P - Om^2 M)^-1 (up_p - j forward_p) Om^2
///
/// in the sensors.  Stacked over several Om, the rank of [h_1 h_2 ...] is the number of combinations of
/// unbalances that are observable.
struct RotorObservability {
  std::string rotor;
  std::vector<std::string> plane;
  /// An orthonormal basis of the planes' unbalances that the sensors show, [planes x rank], and of those that
  /// they do not.
  Eigen::MatrixXcd observable, unobservable;
  /// Empty if all is observable; else what is not, for the driver.
  std::string sentence;
};

/// @param sensors  rows of `acceleration` to look at; empty: all
/// @param omega    rotation rates, rad/s; those of the speeds driven at
std::vector<RotorObservability> observability(const AffineModel& model, const ModelMatrices& at,
                                              const std::vector<int>& sensors,
                                              const std::vector<double>& omega);

}  // namespace roadbalance
