#pragma once

#include <complex>

#include <Eigen/Core>

#include "common/dsp/linear_filter.hpp"

namespace roadbalance {

/// M y'' + P y' + Q y = B2 u'' + B1 u' + B0 u: the outputs y under inputs u.
struct MotionEquation {
  Eigen::MatrixXd M, P, Q;     ///< [outputs x outputs], M regular
  Eigen::MatrixXd B2, B1, B0;  ///< [outputs x inputs]

  static MotionEquation zero(Eigen::Index outputs, Eigen::Index inputs);

  /// Y / U at s = j omega, [outputs x inputs].
  Eigen::MatrixXcd response(double omega) const;
};

/// A MotionEquation run sample by sample, all inputs through one matrix.
///
/// Observer form, in which no input has to be differentiated: with y = M^-1 (x_1 + B2 u)
///
///     x_1' = x_2 - P y + B1 u,   x_2' = -Q y + B0 u.
///
/// From sample to sample exact for inputs that are linear between them.  Such inputs are, of a sinusoid of
/// w step = theta, too small by theta^2 / 12 (the gain of a linear interpolation is sinc^2); each input of
/// the states is therefore raised by a twelfth of its second difference, which leaves theta^4 / 90 (3e-5 at
/// 18 Hz and 500 Hz, in place of 4e-3).  That takes the sample to come: outputs are one sample behind.
class MotionFilter {
 public:
  /// @throws std::invalid_argument if M is singular, the motion is not stable, or step_s is not positive
  MotionFilter(const MotionEquation& equation, double step_s);

  /// Takes u[k+1], returns y[k]; valid until the next call.  Never allocates.
  const Eigen::VectorXd& update(const Eigen::Ref<const Eigen::VectorXd>& next);

  /// Starts again from rest, with inputs before the first one equal to zero.
  void reset();

  /// Goes on where another of as many inputs and outputs stands: with other values in its equation that is
  /// off by as much as they are, until it has settled.
  void go_on_from(const MotionFilter& other);

  /// Until what was before has decayed to `share`, by the slowest pole, s.
  double settling_s(double share) const;

 private:
  DiscreteSystem discrete_;
  Eigen::MatrixXd from_state_, from_input_;
  double slowest_per_s_;
  Eigen::VectorXd x_, next_x_, last_, now_, raised_last_, raised_, y_;
};

}  // namespace roadbalance
