#include "host/identify/between_drives.hpp"

namespace roadbalance {

Eigen::VectorXd unequal_jackknife_variance(const Eigen::VectorXd& whole, const Eigen::MatrixXd& left_out,
                                           const Eigen::VectorXd& weight) {
  const auto groups = static_cast<double>(weight.size());
  const double sum = weight.sum();
  Eigen::VectorXd centre = groups * whole;
  for (Eigen::Index j = 0; j < weight.size(); ++j) centre -= (1.0 - weight(j) / sum) * left_out.col(j);
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(whole.size());
  for (Eigen::Index j = 0; j < weight.size(); ++j) {
    const double h = sum / weight(j);
    variance += (h * whole - (h - 1.0) * left_out.col(j) - centre).cwiseAbs2() / (h - 1.0);
  }
  return variance / groups;
}

}  // namespace roadbalance
