#pragma once

#include <optional>

#include <Eigen/Core>

namespace roadbalance {

/// Tensions f0 of springs and tyres that balance the weights: slope f0 + weight = 0, of all that do those of
/// the least sum of squares.
struct Equilibrium {
  Eigen::MatrixXd tension_of_weight;        ///< f0 = tension_of_weight weight, [elements x f]
  std::optional<Eigen::Index> not_carried;  ///< a coordinate along which nothing balances the weight
};

/// @param slope   ds/dq at rest of what each element is stretched by, [f x elements]; 0 of what carries
/// nothing
/// @param weight  sum m g dz/dq at rest, N
Equilibrium equilibrium(const Eigen::MatrixXd& slope, const Eigen::VectorXd& weight);

}  // namespace roadbalance
