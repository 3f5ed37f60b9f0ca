#include "common/multibody/equilibrium.hpp"

#include <Eigen/QR>
#include <cmath>

namespace roadbalance {

Equilibrium equilibrium(const Eigen::MatrixXd& slope, const Eigen::VectorXd& weight) {
  Equilibrium result;
  result.tension_of_weight.setZero(slope.cols(), slope.rows());
  if (slope.cols() > 0)
    result.tension_of_weight =
        -Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(slope).pseudoInverse();
  // Without what rounding leaves of 0 and of whole numbers.
  for (double& share : result.tension_of_weight.reshaped()) share = 1e-12 * std::round(1e12 * share);
  const Eigen::VectorXd left = weight + slope * (result.tension_of_weight * weight);
  Eigen::Index worst = 0;
  if (left.cwiseAbs().maxCoeff(&worst) > 1e-9 * weight.cwiseAbs().maxCoeff()) result.not_carried = worst;
  return result;
}

}  // namespace roadbalance
