#pragma once

#include <utility>
#include <vector>

#include "common/multibody/expression_matrix.hpp"
#include "common/multibody/kinematics.hpp"

namespace roadbalance {

/// Of something that springs and dampers act on, s(q).
struct StretchDerivatives {
  ExpressionRow slope;         ///< ds/dq at rest
  ExpressionMatrix curvature;  ///< d^2 s / dq^2 at rest
};

/// Derivatives at rest, q = 0.
class Linearisation {
 public:
  explicit Linearisation(const std::vector<Expression>& coordinates);

  Expression at_rest(const Expression& x) const { return x.with(rest_).simplified(); }
  /// dx/dq_i, one entry for each coordinate, in x's unit per that of the coordinate (m or rad).
  ExpressionRow slope(const Expression& x) const;
  /// d^2 x / dq_i dq_j, symmetric, [coordinate x coordinate].
  ExpressionMatrix curvature(const Expression& x) const;

  StretchDerivatives stretch(const Expression& s) const { return {slope(s), curvature(s)}; }
  /// Of the length of `apart`, which is `length` at rest:
  /// s_i = r r_i / l,  s_ij = (r_i r_j + r r_ij - s_i s_j) / l
  StretchDerivatives of_length(const ExpressionVector& apart, const Expression& length) const;

 private:
  std::vector<Expression> coordinates_;
  std::vector<std::pair<Expression, Expression>> rest_;
};

}  // namespace roadbalance
