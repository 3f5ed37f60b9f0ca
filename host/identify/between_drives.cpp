#include "host/identify/between_drives.hpp"

namespace roadbalance {

Eigen::VectorXd variance_between(const Eigen::VectorXd& whole, const Eigen::MatrixXd& left_out,
                                 const Eigen::VectorXd& weight) {
  const Eigen::VectorXd rest = 1.0 - (weight / weight.sum()).array();
  return (left_out.colwise() - whole).cwiseAbs2() * rest;
}

}  // namespace roadbalance
