#include "sim/damper.hpp"

#include <cmath>

namespace roadbalance::sim {
namespace {

constexpr double kSmooth_m_s = 5e-3;  ///< below it dry friction is viscous, so that steps of 1 ms can follow

}  // namespace

bool DamperScenario::is_linear() const {
  return compression == 1.0 && rebound == 1.0 && knee_m_s == 0.0 && friction_n == 0.0;
}

double DamperScenario::excess_n(double damper_n_s_m, double rate_m_s) const {
  const double share = rate_m_s > 0.0 ? rebound : compression;
  const double falls = knee_m_s > 0.0 ? 1.0 / (1.0 + std::abs(rate_m_s) / knee_m_s) : 1.0;
  return damper_n_s_m * rate_m_s * (share * falls - 1.0) + friction_n * std::tanh(rate_m_s / kSmooth_m_s);
}

Dampers::Dampers(const DamperScenario& scenario, const Geometry& geometry, const ParameterVector& parameters)
    : scenario_(scenario), damper_n_s_m_(parameters.segment<kWheels>(kDamper)) {
  for (int i = 0; i < kWheels; ++i) {
    // The damping matrix of a unit damper is B' B, B the row of its stretch, with -1 at its own wheel.
    const Matrix7 unit = linear_model(geometry, ParameterVector::Unit(kDamper + i)).P;
    direction_.col(i) = unit.col(kBodyCoordinates + i);
  }
}

Vector4 Dampers::excess_n(const Vector7& rate) const {
  const Vector4 stretch_m_s = -direction_.transpose() * rate;
  Vector4 force;
  for (int i = 0; i < kWheels; ++i) force(i) = scenario_.excess_n(damper_n_s_m_(i), stretch_m_s(i));
  return force;
}

}  // namespace roadbalance::sim
