#pragma once

#include <array>
#include <vector>

#include "common/multibody/algebra.hpp"
#include "common/multibody/description.hpp"

namespace roadbalance {

using ExpressionVector = std::array<Expression, 3>;  ///< x, y, z
using ExpressionRows = std::array<ExpressionVector, 3>;

ExpressionVector operator+(const ExpressionVector& a, const ExpressionVector& b);
ExpressionVector operator-(const ExpressionVector& a, const ExpressionVector& b);
ExpressionVector operator*(const ExpressionRows& a, const ExpressionVector& b);
ExpressionRows operator*(const ExpressionRows& a, const ExpressionRows& b);
ExpressionRows transposed(const ExpressionRows& a);
Expression dot(const ExpressionVector& a, const ExpressionVector& b);

/// The symbols of a description, as its formulas see them.
class Names {
 public:
  explicit Names(const Description& description);

  Expression operator()(const Formula& formula) const;
  ExpressionVector operator()(const std::array<Formula, 3>& formulas) const;

  const std::vector<Expression>& coordinates() const { return coordinates_; }
  const std::vector<Expression>& parameters() const { return parameters_; }
  const std::vector<Expression>& geometry() const { return geometry_; }

 private:
  std::vector<std::pair<std::string, Expression>> all_;
  std::vector<Expression> coordinates_, parameters_, geometry_;
};

/// Where a body is, as a function of the coordinates, with all rotations in full.
struct BodyFrame {
  ExpressionVector position;  ///< of its origin, in the axes of the ground
  ExpressionRows rotation;    ///< its axes -> those of the ground

  ExpressionVector at(const ExpressionVector& place) const { return position + rotation * place; }
};

/// The ground: it does not move.
BodyFrame ground();

/// All bodies: r = r_on + R_on position, R = R_on R_axis1(angle1) R_axis2(angle2) ...
std::vector<BodyFrame> frames(const Description& description, const Names& names);

}  // namespace roadbalance
