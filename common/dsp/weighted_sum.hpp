#pragma once

#include <Eigen/Core>

namespace roadbalance {

/// sum = columns weight: a filter's output for all channels at once.  The same bits on every processor.
///
/// @param columns  [row x weight]
/// @param sum      [row], none of the others
void weighted_sum(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                  const Eigen::Ref<const Eigen::VectorXd>& weight, Eigen::Ref<Eigen::VectorXd> sum);

}  // namespace roadbalance
