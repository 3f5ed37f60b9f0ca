#pragma once

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"

namespace roadbalance::sim {

using Vector4 = Eigen::Matrix<double, kWheels, 1>;

/// How the struts' dampers differ from the linear ones of the model:
///
///     F(v) = d v s(v) / (1 + |v| / knee) + friction tanh(v / 5 mm/s),
///
/// v the rate at which a strut stretches, d its damper in the model, s rebound for v > 0 and compression for
/// v < 0.
struct DamperScenario {
  double compression = 1.0;
  double rebound = 1.0;
  double knee_m_s = 0.0;    ///< at which a degressive damper gives half of d v; 0: it is not degressive
  double friction_n = 0.0;  ///< of the strut, dry; smooth below 5 mm/s

  bool is_linear() const;
  /// F(v) - d v, N, for a strut of d N s/m.
  double excess_n(double damper_n_s_m, double rate_m_s) const;
};

/// The dampers of a car: the part of their forces beyond the linear ones.
class Dampers {
 public:
  /// @param parameters  of the car, of which the struts' dampers count
  Dampers(const DamperScenario& scenario, const Geometry& geometry, const ParameterVector& parameters);

  bool are_linear() const { return scenario_.is_linear(); }
  /// Generalised force on the car per force of each strut that pulls its ends together.
  const Matrix74& direction() const { return direction_; }
  /// Force of each strut, N.
  /// @param rate  z'
  Vector4 excess_n(const Vector7& rate) const;

 private:
  DamperScenario scenario_;
  Matrix74 direction_;
  Vector4 damper_n_s_m_;
};

}  // namespace roadbalance::sim
