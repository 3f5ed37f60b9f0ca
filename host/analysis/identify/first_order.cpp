#include "host/analysis/identify/first_order.hpp"

#include <cmath>
#include <limits>

#include "host/analysis/identify/unbalances.hpp"

namespace roadbalance {

FirstOrderFit fit_first_order(std::span<const FirstOrderForce> forces) {
  double k0 = 0.0, k2 = 0.0, k4 = 0.0;  // sums of k Om^0, Om^2, Om^4
  std::complex<double> a0, a2;          // of k a, k Om^2 a
  for (const FirstOrderForce& force : forces) {
    const double k = 1.0 / force.variance_n2;
    const double om2 = force.omega * force.omega;
    k0 += k;
    k2 += k * om2;
    k4 += k * om2 * om2;
    a0 += k * force.force_n;
    a2 += k * om2 * force.force_n;
  }
  FirstOrderFit fit;
  fit.sigma_equivalent_kg_m = 1.0 / std::sqrt(k4);
  // 1 - r^2 of the two columns; below rounding all speeds are one.
  const double apart = 1.0 - k2 * k2 / (k4 * k0);
  fit.sigma_unbalance_kg_m = fit.sigma_force_n = std::numeric_limits<double>::infinity();
  if (apart < 1e-12) {
    constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    fit.unbalance_kg_m = fit.force_n = {kUnknown, kUnknown};
    return fit;
  }
  fit.sigma_unbalance_kg_m = fit.sigma_equivalent_kg_m / std::sqrt(apart);
  fit.sigma_force_n = 1.0 / std::sqrt(k0 * apart);
  fit.unbalance_kg_m = (a2 / k4 - a0 * (k2 / (k4 * k0))) / apart;
  fit.force_n = (a0 / k0 - a2 * (k2 / (k4 * k0))) / apart;
  fit.separable = fit.sigma_unbalance_kg_m <= kSeparable * fit.sigma_equivalent_kg_m;
  return fit;
}

std::array<FirstOrderForce, kWheels> first_order_forces(const HarmonicMoments& moments,
                                                        const Geometry& geometry,
                                                        const ParameterVector& parameters,
                                                        const Eigen::Vector4d& omega,
                                                        const std::bitset<kWheels>& asked) {
  ParameterVector without_tyres = parameters;
  without_tyres.segment<kWheels>(kTyre).setZero();
  const Unbalances unbalances = solve_unbalances(moments, geometry, without_tyres, asked);
  const Eigen::Vector4cd equivalent = unbalances.at(parameters.segment<kWheels>(kTyre));
  std::array<FirstOrderForce, kWheels> forces{};
  for (int i = 0; i < kWheels; ++i) {
    const double om2 = omega(i) * omega(i);
    forces[static_cast<std::size_t>(i)] = {omega(i), om2 * equivalent(i),
                                           om2 * om2 * unbalances.covariance(i, i).real() / 2.0};
  }
  return forces;
}

}  // namespace roadbalance
