#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/dsp/taper.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {

/// Phasors of a section at its wheels' rates.
struct DemodulatedLines {
  std::vector<int> wheels;   ///< the references, in this order; empty: none
  Eigen::MatrixXcd Z;        ///< [reference x coordinate] phasors of z''
  Eigen::MatrixXcd overlap;  ///< c [j x k]: what a unit phasor of reference j gives at reference k
  /// [reference x reference] inverse of K, the overlap of the references under the squared taper: how noise
  /// of one reference's phasor goes with that of another's.
  Eigen::MatrixXcd K_inverse;
};

/// A section demodulated with the angle of each wheel that has one.
struct Demodulated : DemodulatedLines {
  double effective_s = 0.0;  ///< length of an even window that lets as much noise in
  Eigen::MatrixXcd down;  ///< [reference x sample] conjugate reference under the taper, gain 1 for a phasor
};

/// Demodulates sections of one length, at the wheels' rates and beside them.
class Demodulator {
 public:
  /// @param taper  of a section; its length is the section's
  Demodulator(Taper taper, double rate_hz);

  /// @param signals  [kSignals x samples]
  /// @param omega    rotation rate of each wheel, rad/s; 0: it has no reference here
  /// @param quiet    [sample] factor of the taper: 0 where something else shakes the car
  Demodulated operator()(const Eigen::Ref<const SignalMatrix>& signals, const Eigen::Vector4d& omega,
                         const Eigen::Ref<const Eigen::ArrayXd>& quiet) const;
  Demodulated operator()(const Eigen::Ref<const SignalMatrix>& signals, const Eigen::Vector4d& omega) const {
    return (*this)(signals, omega, Eigen::ArrayXd::Ones(signals.cols()));
  }

  /// Phasors of z'' at the side bins, [bin x coordinate]: the road's, near the line of the first reference.
  Eigen::MatrixXcd beside(const Eigen::Ref<const SignalMatrix>& signals, const Demodulated& line) const;
  /// Distance of the side bins from the line.
  const Eigen::VectorXd& side_hz() const { return side_hz_; }

 private:
  Taper taper_;
  double rate_hz_;
  Eigen::VectorXd side_hz_;
  Eigen::MatrixXd side_wave_;  ///< [cos, sin of each distance x sample] of 2 pi x t
};

}  // namespace roadbalance
