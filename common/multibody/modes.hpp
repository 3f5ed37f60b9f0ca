#pragma once

#include <complex>
#include <vector>

#include <Eigen/Core>

#include "common/multibody/affine_model.hpp"

namespace roadbalance {

/// A free motion q(t) = Re{shape e^{pole t}} of M q'' + P q' + Q q = 0.
struct Mode {
  std::complex<double> pole;  ///< 1/s, of a pair the one with imag >= 0
  Eigen::VectorXcd shape;     ///< its largest component is 1

  bool swings() const { return pole.imag() > 0.0; }
  double frequency_hz() const;  ///< |pole| / 2 pi: undamped
  double damping() const;       ///< -Re pole / |pole|
};

/// By frequency; those that do not swing behind one another by the same measure.
std::vector<Mode> modes(const ModelMatrices& model);

}  // namespace roadbalance
