#include "host/analysis/balance/overall.hpp"

#include <Eigen/QR>
#include <cmath>
#include <complex>
#include <stdexcept>

namespace roadbalance {

std::optional<OverallCompensation> compensate_overall(const std::vector<ResponsePoint>& points) {
  if (points.empty()) return std::nullopt;
  const Eigen::Index wheels = points.front().per_force.size(), count = std::ssize(points);
  Eigen::MatrixXcd A(count, wheels);  // sqrt(k) H Om^2
  Eigen::VectorXcd R(count);          // sqrt(k) R
  double weights = 0.0;
  for (Eigen::Index p = 0; p < count; ++p) {
    const ResponsePoint& point = points[static_cast<std::size_t>(p)];
    if (point.per_force.size() != wheels || point.omega.size() != wheels || !(point.weight > 0.0))
      throw std::invalid_argument(
          "overall compensation: points differ in their wheels, or one has no weight");
    const double root = std::sqrt(point.weight);
    A.row(p) = root * point.per_force.cwiseProduct(point.omega.cwiseAbs2().cast<std::complex<double>>());
    R(p) = root * point.measured;
    weights += point.weight;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXcd> qr(A);
  qr.setThreshold(1e-9);
  if (count < wheels || qr.rank() < wheels) return std::nullopt;
  OverallCompensation result;
  result.correction_kg_m = -qr.solve(R);
  const Eigen::VectorXcd left = R + A * result.correction_kg_m;
  result.rms_before = R.norm() / std::sqrt(weights);
  result.rms_after = left.norm() / std::sqrt(weights);
  result.residual = left;
  for (Eigen::Index p = 0; p < count; ++p)
    result.residual(p) /= std::sqrt(points[static_cast<std::size_t>(p)].weight);
  return result;
}

}  // namespace roadbalance
