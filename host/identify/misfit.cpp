#include "host/identify/misfit.hpp"

#include <Eigen/LU>
#include <cmath>
#include <complex>

#include "host/identify/confidence.hpp"

namespace roadbalance {

CheckResiduals check_residuals(const DriveMoments& moments, const UnknownVector& x, const Geometry& geometry,
                               const ParameterVector& known) {
  ParameterVector parameters = known;
  parameters.segment<kEstimatedUnbalance>(kSpring) = x.head<kEstimatedUnbalance>();
  const LinearModel model = linear_model(geometry, parameters);
  CheckResiduals residuals;
  for (int w = 0; w < kWheels; ++w) {
    std::complex<double> unbalance(x(kEstimatedUnbalance + 2 * w), x(kEstimatedUnbalance + 2 * w + 1));
    if (!std::isfinite(unbalance.real())) unbalance = 0.0;  // without a reference: as if balanced
    for (int k = 0; k < kWheelChecks; ++k) {
      const auto& check = moments.wheel[static_cast<std::size_t>(w)].check[static_cast<std::size_t>(k)];
      residuals(w, k) =
          (check.tyre.force(model, kBodyCoordinates + w) - (check.tyre_unbalance * unbalance).real()) /
          moments.seconds;
    }
  }
  return residuals;
}

Misfit judge_misfit(const Eigen::Vector2d& residual, const Eigen::Matrix2d& covariance,
                    const Eigen::Vector2d& per_share, std::size_t groups) {
  Misfit misfit;
  const Eigen::Matrix2d inverse = covariance.inverse();
  const double information = per_share.dot(inverse * per_share);
  if (groups < 4 || !inverse.allFinite() || !(information > 0.0)) return misfit;
  const double n = static_cast<double>(groups);
  misfit.square = residual.dot(inverse * residual);
  // The tail of F(2, d) at f is (1 + 2 f / d)^(-d / 2).
  misfit.chance = std::pow(1.0 + misfit.square / (n - 1.0), -0.5 * (n - 2.0));
  misfit.gain = -inverse * per_share / information;
  misfit.share = misfit.gain.dot(residual);
  misfit.sigma_share = std::sqrt(few_groups_factor(n) / information);
  return misfit;
}

}  // namespace roadbalance
