#include "common/multibody/linearisation.hpp"

namespace roadbalance {

Linearisation::Linearisation(const std::vector<Expression>& coordinates) : coordinates_(coordinates) {
  for (const Expression& q : coordinates_) rest_.emplace_back(q, Expression(0.0));
}

ExpressionRow Linearisation::slope(const Expression& x) const {
  ExpressionRow row(coordinates_.size());
  for (std::size_t i = 0; i < row.size(); ++i)
    if (x.contains(coordinates_[i])) row[i] = at_rest(x.derivative(coordinates_[i]));
  return row;
}

ExpressionMatrix Linearisation::curvature(const Expression& x) const {
  const std::size_t f = coordinates_.size();
  ExpressionMatrix matrix(f, f);
  for (std::size_t i = 0; i < f; ++i) {
    if (!x.contains(coordinates_[i])) continue;
    const Expression first = x.derivative(coordinates_[i]);
    for (std::size_t j = i; j < f; ++j)
      if (first.contains(coordinates_[j]))
        matrix(i, j) = matrix(j, i) = at_rest(first.derivative(coordinates_[j]));
  }
  return matrix;
}

StretchDerivatives Linearisation::of_length(const ExpressionVector& apart, const Expression& length) const {
  const std::size_t f = coordinates_.size();
  StretchDerivatives result{ExpressionRow(f), ExpressionMatrix(f, f)};
  for (const Expression& part : apart) {
    const Expression r = at_rest(part);
    const ExpressionRow first = slope(part);
    for (std::size_t i = 0; i < f; ++i) result.slope[i] += r * first[i] / length;
    result.curvature.add_product(1.0 / length, first, first);
    result.curvature.add(r / length, curvature(part));
  }
  for (Expression& x : result.slope) x = x.simplified();
  result.curvature.add_product(-1.0 / length, result.slope, result.slope);
  for (std::size_t i = 0; i < f; ++i)
    for (std::size_t j = 0; j < f; ++j) result.curvature(i, j) = result.curvature(i, j).simplified();
  return result;
}

}  // namespace roadbalance
