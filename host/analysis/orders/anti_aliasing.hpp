#pragma once

#include <complex>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Effect of the filter of vehicle.toml on orders in a record.
///
/// Accelerations and angle references have passed the same filter H, so the first order keeps its phase.
/// Another order h of a wheel at f turns a second is delayed by H(h f), its angle by h times the phase of
/// H(f): order 6 at 200 Hz, order 2 of 18 turns a second: 0.12 degrees, of 40: 1.4 degrees.
class AntiAliasing {
 public:
  explicit AntiAliasing(const FilterConfig& filter);

  std::complex<double> response(double frequency_hz) const;
  /// The recorded vector of an order that is a unit vector: H(h f) e^{-j h phi(f)}, phi the phase of H,
  /// unwrapped.
  std::complex<double> on_order(double order, double rotation_hz) const;
  /// Up to here the filter takes less than 1 % off.
  double flat_to_hz() const { return flat_to_hz_; }

 private:
  double phase_rad(double frequency_hz) const;

  Eigen::VectorXcd poles_;  ///< rad/s
  double flat_to_hz_;
};

}  // namespace roadbalance
