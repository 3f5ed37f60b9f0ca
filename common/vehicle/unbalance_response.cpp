#include "common/vehicle/unbalance_response.hpp"

#include <Eigen/LU>

namespace roadbalance {

Eigen::Matrix<std::complex<double>, kCoordinates, 1> unbalance_response(const LinearModel& model, int wheel,
                                                                        double omega) {
  using Complex = std::complex<double>;
  const double om2 = omega * omega;
  const Eigen::Matrix<Complex, kCoordinates, kCoordinates> dynamic =
      model.Q.cast<Complex>() + Complex(0.0, omega) * model.P.cast<Complex>() -
      (om2 * model.M).cast<Complex>();
  return -om2 * om2 * dynamic.partialPivLu().solve(model.W.col(wheel).cast<Complex>());
}

}  // namespace roadbalance
