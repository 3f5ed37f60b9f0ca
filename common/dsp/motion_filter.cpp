#include "common/dsp/motion_filter.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace roadbalance {

MotionEquation MotionEquation::zero(Eigen::Index outputs, Eigen::Index inputs) {
  const Eigen::MatrixXd square = Eigen::MatrixXd::Zero(outputs, outputs);
  const Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(outputs, inputs);
  return {square, square, square, wide, wide, wide};
}

Eigen::MatrixXcd MotionEquation::response(double omega) const {
  const std::complex<double> s(0.0, omega);
  const Eigen::MatrixXcd left = s * s * M + s * P + Q;
  return left.partialPivLu().solve(s * s * B2 + s * B1 + B0);
}

MotionFilter::MotionFilter(const MotionEquation& e, double step_s) {
  const auto n = e.M.rows(), inputs = e.B0.cols();
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(e.M);
  if (!lu.isInvertible()) throw std::invalid_argument("a motion without mass");
  const Eigen::MatrixXd inverse = lu.inverse();
  Eigen::MatrixXd F = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  F.topLeftCorner(n, n) = -e.P * inverse;
  F.topRightCorner(n, n).setIdentity();
  F.bottomLeftCorner(n, n) = -e.Q * inverse;
  slowest_per_s_ = -F.eigenvalues().real().maxCoeff();
  constexpr double kLeast_per_s = 1e-6;  // rounding makes poles of what is not damped, too
  if (!(slowest_per_s_ > kLeast_per_s)) throw std::invalid_argument("a motion that does not decay");
  from_input_ = inverse * e.B2;
  from_state_ = Eigen::MatrixXd::Zero(n, 2 * n);
  from_state_.leftCols(n) = inverse;
  Eigen::MatrixXd G(2 * n, inputs);
  G << e.B1 - e.P * from_input_, e.B0 - e.Q * from_input_;
  discrete_ = discretise_ramp_invariant(F, G, step_s);
  x_.resize(2 * n);
  next_x_.resize(2 * n);
  y_.resize(n);
  for (auto* input : {&last_, &now_, &raised_last_, &raised_}) input->resize(inputs);
  reset();
}

void MotionFilter::reset() {
  for (auto* all : {&x_, &last_, &now_, &raised_last_, &raised_}) all->setZero();
}

const Eigen::VectorXd& MotionFilter::update(const Eigen::Ref<const Eigen::VectorXd>& next) {
  raised_ = now_ + (2.0 * now_ - last_ - next) / 12.0;
  next_x_.noalias() = discrete_.A * x_;
  next_x_.noalias() += discrete_.B0 * raised_last_;
  next_x_.noalias() += discrete_.B1 * raised_;
  x_.swap(next_x_);
  y_.noalias() = from_state_ * x_;
  y_.noalias() += from_input_ * now_;
  raised_last_.swap(raised_);
  last_ = now_;
  now_ = next;
  return y_;
}

void MotionFilter::go_on_from(const MotionFilter& other) {
  x_ = other.x_;
  last_ = other.last_;
  now_ = other.now_;
  raised_last_ = other.raised_last_;
}

double MotionFilter::settling_s(double share) const {
  return -std::log(share) / slowest_per_s_;
}

}  // namespace roadbalance
