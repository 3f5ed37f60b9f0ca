#pragma once

#include <array>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"

namespace roadbalance::sim {

using Array4 = Eigen::Array<double, kWheels, 1>;

/// Fore-and-aft and sideways shaking of the four wheel carriers: a plausible secondary model, so that the
/// horizontal channels show something a car would.  Nothing identifies it.
///
/// Each carrier is a mass on a rubber bush in either direction, x'' + 2 D w x' + w^2 x = F / m with the
/// scenario's frequency, D = 0.15 fore and aft, 15 Hz, D = 0.2 sideways; forces are taken as linear between
/// steps.
class PlanarMotion {
 public:
  PlanarMotion(const ParameterVector& parameters, double forward_hz, double step_s);

  /// @param forward_n, left_n  forces on the carriers at the end of this step
  void step(const Array4& forward_n, const Array4& left_n);

  const Array4& forward_m_s2() const { return direction_[0].acceleration; }
  const Array4& left_m_s2() const { return direction_[1].acceleration; }

 private:
  struct Resonator {
    std::array<double, 4> transition;   ///< row-major 2 x 2 of [displacement, velocity]
    std::array<double, 2> before, now;  ///< effect of the specific force at both ends of the step
    double stiffness_1_s2, damping_1_s;
    Array4 displacement = Array4::Zero(), velocity = Array4::Zero(), last = Array4::Zero();
    Array4 acceleration = Array4::Zero();

    Resonator(double frequency_hz, double damping, double step_s);
    void step(const Array4& specific_force_m_s2);
  };

  Array4 mass_kg_;
  std::array<Resonator, 2> direction_;
};

}  // namespace roadbalance::sim
