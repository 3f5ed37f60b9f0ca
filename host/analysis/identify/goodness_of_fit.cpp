#include "host/analysis/identify/goodness_of_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>

#include "host/analysis/identify/confidence.hpp"

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

GoodnessOfFit goodness_of_fit(const Eigen::Vector2d& residual, const Eigen::Matrix2d& covariance,
                              const Eigen::Vector2d& per_share, double groups) {
  GoodnessOfFit fit;
  const Eigen::Matrix2d inverse = covariance.inverse();
  const double information = per_share.dot(inverse * per_share);
  if (groups < 4.0 || !inverse.allFinite() || !(information > 0.0)) return fit;
  fit.square = residual.dot(inverse * residual);
  // The tail of F(2, d) at f is (1 + 2 f / d)^(-d / 2).
  fit.chance = std::pow(1.0 + fit.square / (groups - 1.0), -0.5 * (groups - 2.0));
  fit.gain = -inverse * per_share / information;
  fit.share = fit.gain.dot(residual);
  fit.sigma_share = std::sqrt(few_groups_factor(groups) / information);
  return fit;
}

double chance_of_residuals(const Eigen::VectorXd& residual, const Eigen::MatrixXd& left_out, double groups,
                           double allowed) {
  const auto n = static_cast<double>(left_out.cols());
  const auto many = static_cast<double>(residual.size());
  if (groups < 8.0) return 1.0;  // so few give no sigma
  Eigen::MatrixXd scatter = left_out.colwise() - left_out.rowwise().mean();
  scatter *= std::sqrt((n - 1.0) / n);
  const Eigen::VectorXd sigma =
      (scatter.rowwise().squaredNorm().array() + allowed * allowed / many).sqrt().matrix();
  const Eigen::MatrixXd inner = scatter.transpose() * sigma.cwiseAbs2().cwiseInverse().asDiagonal() * scatter;
  const double trace = inner.trace();
  if (!std::isfinite(trace)) return 1.0;
  // tr R^2 from few groups is too large by what its own scatter adds.
  const double square = (inner.squaredNorm() - trace * trace / (groups - 1.0)) * (groups - 1.0) *
                        (groups - 1.0) / ((groups - 2.0) * (groups + 1.0));
  const double alike = square > 0.0 ? std::clamp(trace * trace / square, 1.0, many) : many;
  const double k = alike * (groups - 5.0) / (groups - 2.0);
  const double X = residual.cwiseQuotient(sigma).squaredNorm() / many * (groups - 3.0) / (groups - 1.0);
  const double a = 2.0 / (9.0 * k);
  return 0.5 * std::erfc((std::cbrt(X) - (1.0 - a)) / std::sqrt(2.0 * a));
}

}  // namespace roadbalance
