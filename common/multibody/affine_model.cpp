#include "common/multibody/affine_model.hpp"

#include <algorithm>
#include <array>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

using Replaced = std::vector<std::pair<Expression, Expression>>;

Eigen::MatrixXd zero(const ExpressionMatrix& m) {
  return Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(m.rows()), static_cast<Eigen::Index>(m.columns()));
}

Eigen::MatrixXd numbers(const ExpressionMatrix& m, const Replaced& values) {
  Eigen::MatrixXd result = zero(m);
  for (std::size_t i = 0; i < m.rows(); ++i)
    for (std::size_t j = 0; j < m.columns(); ++j)
      if (!m(i, j).is_zero())
        result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = m(i, j).with(values).number();
  return result;
}

/// The six matrices, of expressions and of numbers, in the same order.
std::array<const ExpressionMatrix*, 6> six(const Equations& e) {
  return {&e.M, &e.P, &e.Q, &e.S, &e.Sd, &e.T};
}
std::array<Eigen::MatrixXd*, 6> six(ModelMatrices& m) {
  return {&m.M, &m.P, &m.Q, &m.S, &m.Sd, &m.T};
}

ModelMatrices zero(const Equations& e) {
  ModelMatrices m;
  for (std::size_t k = 0; k < 6; ++k) *six(m)[k] = zero(*six(e)[k]);
  return m;
}

}  // namespace

ModelMatrices& ModelMatrices::operator+=(const ModelMatrices& other) {
  M += other.M;
  P += other.P;
  Q += other.Q;
  S += other.S;
  Sd += other.Sd;
  T += other.T;
  return *this;
}

ModelMatrices operator*(double factor, ModelMatrices m) {
  for (Eigen::MatrixXd* matrix : six(m)) *matrix *= factor;
  return m;
}

ModelMatrices AffineModel::at(const Eigen::VectorXd& parameters) const {
  ModelMatrices sum = constant;
  for (std::size_t k = 0; k < of.size(); ++k) sum += parameters(static_cast<Eigen::Index>(k)) * of[k];
  return sum;
}

AffineModel affine_model(const Equations& e, const std::vector<std::string>& chosen) {
  AffineModel model;
  for (const NamedValue& one : e.coordinate) model.coordinate.push_back(one.name);
  model.tyre = e.tyre;
  model.rotor = e.rotor;
  model.sensor = e.sensor;
  model.parameter = chosen;
  model.nominal.resize(static_cast<Eigen::Index>(chosen.size()));

  std::vector<Expression> symbol(chosen.size());
  Replaced known, all;
  for (std::size_t k = 0; k < e.geometry.size(); ++k)
    known.emplace_back(e.geometry_symbol[k], Expression(e.geometry[k].value));
  std::size_t found = 0;
  for (std::size_t k = 0; k < e.parameter.size(); ++k) {
    const auto place = std::ranges::find(chosen, e.parameter[k].name);
    all.emplace_back(e.parameter_symbol[k], Expression(e.parameter[k].value));
    if (place == chosen.end()) {
      known.push_back(all.back());
      continue;
    }
    ++found;
    symbol[static_cast<std::size_t>(place - chosen.begin())] = e.parameter_symbol[k];
    model.nominal(place - chosen.begin()) = e.parameter[k].value;
  }
  if (found != chosen.size()) throw ConfigError(e.name + ": a chosen name is no parameter of it");
  all.insert(all.end(), known.begin(), known.end());

  model.acceleration = numbers(e.acceleration, all);
  model.tilt = numbers(e.tilt, all);
  model.up = numbers(e.up, all);
  model.forward = numbers(e.forward, all);
  for (const UnbalanceDescription& plane : e.unbalance)
    model.plane.push_back(
        {plane.name, static_cast<int>(std::ranges::find(e.rotor, plane.rotor) - e.rotor.begin())});

  Replaced at_rest;
  for (const auto* kind : {&e.length, &e.tension})
    for (const Equations::AtRest& one : *kind) at_rest.emplace_back(one.symbol, one.value);
  Replaced none;
  for (const Expression& one : symbol) none.emplace_back(one, Expression(0.0));
  model.constant = zero(e);
  model.of.assign(chosen.size(), zero(e));
  for (std::size_t which = 0; which < 6; ++which) {
    const ExpressionMatrix& matrix = *six(e)[which];
    for (std::size_t i = 0; i < matrix.rows(); ++i)
      for (std::size_t j = 0; j < matrix.columns(); ++j) {
        if (matrix(i, j).is_zero()) continue;
        const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
        const Expression entry = matrix(i, j).with(at_rest).with(known);
        (*six(model.constant)[which])(row, column) = entry.with(none).number();
        for (std::size_t k = 0; k < symbol.size(); ++k) {
          if (!entry.contains(symbol[k])) continue;
          const Expression slope = entry.derivative(symbol[k]).simplified();
          if (!slope.is_number())
            throw ConfigError(e.name + ": the equations are not affine in " + chosen[k] + ": " + entry.cpp());
          (*six(model.of[k])[which])(row, column) = slope.number();
        }
      }
  }
  return model;
}

AffineModel affine_model(const Equations& equations) {
  std::vector<std::string> all;
  for (const NamedValue& one : equations.parameter) all.push_back(one.name);
  return affine_model(equations, all);
}

}  // namespace roadbalance
