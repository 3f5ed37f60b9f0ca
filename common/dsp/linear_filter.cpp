#include "common/dsp/linear_filter.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <unsupported/Eigen/MatrixFunctions>

namespace roadbalance {

ContinuousFilter companion(const Eigen::VectorXd& denominator) {
  const auto n = denominator.size();
  ContinuousFilter filter{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
  filter.F.topRightCorner(n - 1, n - 1).setIdentity();
  filter.F.row(n - 1) = -denominator.transpose();
  filter.G(n - 1) = 1.0;
  return filter;
}

ContinuousFilter butterworth(int order, double cutoff_hz) {
  if (order < 1 || order > 12) throw std::invalid_argument("Butterworth order must be 1 .. 12");
  if (!(cutoff_hz > 0.0)) throw std::invalid_argument("Butterworth cut-off must be positive");
  // D(s) = s^n + ... with D's coefficients a[k+1] = a[k] cos(k pi / 2n) / sin((k+1) pi / 2n), a[0] = 1.
  // Source: U. Tietze, Ch. Schenk, Electronic Circuits, Springer, ch. 13 (recursion of the Butterworth
  // polynomial).
  Eigen::VectorXd a(order);
  double coefficient = 1.0;
  for (int k = 0; k < order; ++k) {
    a(k) = coefficient;
    const double angle = std::numbers::pi / (2.0 * order);
    coefficient *= std::cos(k * angle) / std::sin((k + 1) * angle);
  }
  ContinuousFilter filter = companion(a);
  const double corner_rad_s = 2.0 * std::numbers::pi * cutoff_hz;
  filter.F *= corner_rad_s;
  filter.G *= corner_rad_s;
  return filter;
}

DiscreteFilter discretise_ramp_invariant(const ContinuousFilter& filter, double step_s) {
  const DiscreteSystem system = discretise_ramp_invariant(filter.F, filter.G, step_s);
  return {system.A, system.B0, system.B1};
}

DiscreteSystem discretise_ramp_invariant(const Eigen::MatrixXd& F, const Eigen::MatrixXd& G, double step_s) {
  if (!(step_s > 0.0)) throw std::invalid_argument("filter step must be positive");
  const auto n = G.rows(), inputs = G.cols();
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(n + 2 * inputs, n + 2 * inputs);
  block.topLeftCorner(n, n) = F * step_s;
  block.block(0, n, n, inputs) = G * step_s;
  // In units of the step, so that the exponential stays well scaled.
  block.block(n, n + inputs, inputs, inputs).setIdentity();
  const Eigen::MatrixXd e = block.exp();
  const Eigen::MatrixXd ramp = e.block(0, n + inputs, n, inputs);
  return {e.topLeftCorner(n, n), e.block(0, n, n, inputs) - ramp, ramp};
}

}  // namespace roadbalance
