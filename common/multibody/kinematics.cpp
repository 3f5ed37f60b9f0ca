#include "common/multibody/kinematics.hpp"

#include <algorithm>
#include <cassert>

namespace roadbalance {
namespace {

ExpressionRows unit_rows() {
  ExpressionRows rows;
  for (std::size_t i = 0; i < 3; ++i) rows[i][i] = Expression(1.0);
  return rows;
}

/// Right-handed about one of its own axes.
ExpressionRows turn(char axis, const Expression& angle) {
  const auto a = static_cast<std::size_t>(axis - 'x');
  const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
  ExpressionRows rows = unit_rows();
  rows[b][b] = rows[c][c] = cos(angle);
  rows[c][b] = sin(angle);
  rows[b][c] = -sin(angle);
  return rows;
}

}  // namespace

ExpressionVector operator+(const ExpressionVector& a, const ExpressionVector& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

ExpressionVector operator-(const ExpressionVector& a, const ExpressionVector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Expression dot(const ExpressionVector& a, const ExpressionVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

ExpressionVector operator*(const ExpressionRows& a, const ExpressionVector& b) {
  return {dot(a[0], b), dot(a[1], b), dot(a[2], b)};
}

ExpressionRows transposed(const ExpressionRows& a) {
  ExpressionRows rows;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) rows[i][j] = a[j][i];
  return rows;
}

ExpressionRows operator*(const ExpressionRows& a, const ExpressionRows& b) {
  const ExpressionRows columns = transposed(b);
  ExpressionRows rows;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) rows[i][j] = dot(a[i], columns[j]);
  return rows;
}

Names::Names(const Description& description) {
  const auto add = [this](const std::vector<NamedValue>& values, std::vector<Expression>& symbols) {
    for (const NamedValue& one : values) {
      symbols.push_back(Expression::symbol(one.name, one.latex, one.value > 0.0));
      all_.emplace_back(one.name, symbols.back());
    }
  };
  add(description.coordinate, coordinates_);
  add(description.parameter, parameters_);
  add(description.geometry, geometry_);
}

Expression Names::operator()(const Formula& formula) const {
  return formula.value<Expression>([this](const std::string& name) {
    const auto found = std::ranges::find(all_, name, &std::pair<std::string, Expression>::first);
    assert(found != all_.end());
    return found->second;
  });
}

ExpressionVector Names::operator()(const std::array<Formula, 3>& formulas) const {
  return {(*this)(formulas[0]), (*this)(formulas[1]), (*this)(formulas[2])};
}

BodyFrame ground() {
  return {{}, unit_rows()};
}

std::vector<BodyFrame> frames(const Description& description, const Names& names) {
  std::vector<BodyFrame> all;
  for (const BodyDescription& body : description.body) {
    const BodyFrame on =
        body.on == BodyDescription::kGround ? ground() : all[static_cast<std::size_t>(body.on)];
    BodyFrame frame{on.at(names(body.position)), on.rotation};
    for (std::size_t k = 0; k < body.axes.size(); ++k)
      frame.rotation = frame.rotation * turn(body.axes[k], names(body.angle[k]));
    all.push_back(frame);
  }
  return all;
}

}  // namespace roadbalance
