#pragma once

#include <bitset>
#include <complex>
#include <functional>
#include <map>
#include <utility>

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/demodulation.hpp"
#include "host/analysis/identify/stretch.hpp"

namespace roadbalance {

/// Correlations of the accelerations with harmonic functions of the wheels' angles, of stretches at one
/// speed; two add by +=.  Rows of wheels without a reference are 0.
///
/// With U_i the unbalance and G_i(Om) the accelerations that a unit of it makes,
///
///     Z_k = sum_i C_ik G_i(Om_i) U_i + n_k,    E[n_k n_l^H] = K_kl S.
struct LinePhasors {
  using RowPhasors = Eigen::Matrix<std::complex<double>, kWheels, kCoordinates>;
  using Spectrum = Eigen::Matrix<std::complex<double>, kCoordinates, kCoordinates>;

  double seconds = 0.0;
  Eigen::Vector4d turned_rad = Eigen::Vector4d::Zero();  ///< by each wheel
  RowPhasors Z = RowPhasors::Zero();                     ///< sum over parts of the phasors of z''
  Eigen::Matrix4cd C = Eigen::Matrix4cd::Zero();  ///< sum of what a unit phasor of one wheel gives at another
  Eigen::Matrix4cd K = Eigen::Matrix4cd::Zero();  ///< sum of how noise of two wheels' phasors goes together
  Spectrum beside = Spectrum::Zero();             ///< sum of phasors' products Z' Z^* beside the lines
  double bins = 0.0;                              ///< how many

  Eigen::Vector4d omega() const { return turned_rad / seconds; }
  bool has(int wheel) const { return C(wheel, wheel) != 0.0; }
  /// S of one part's phasors, as column times conjugate row.
  Spectrum noise() const { return beside / bins; }

  LinePhasors& operator+=(const LinePhasors& other);
};

/// Takes the phasors of stretches, in parts of about 10 s under a C2 taper of 20 %.
class LineCorrelator {
 public:
  using Emit = std::function<void(const LinePhasors&)>;

  /// @param wheels  whose angles are correlated with
  explicit LineCorrelator(std::bitset<kWheels> wheels) : wheels_(wheels) {}

  void parts(const Stretch& stretch, const Emit& emit);

 private:
  std::bitset<kWheels> wheels_;
  std::map<std::pair<double, Eigen::Index>, Demodulator> demodulators_;  ///< by rate and length
};

}  // namespace roadbalance
