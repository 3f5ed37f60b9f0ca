#include "host/analysis/balance/four_run.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace roadbalance {
namespace {

struct Solved {
  double ratio;      ///< V / T
  double angle_rad;  ///< phi
  double agreement;
};

std::optional<Solved> solve(double bare, const Eigen::VectorXd& amplitude, const Eigen::MatrixXd& shape) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(shape);
  if (qr.rank() < 3) return std::nullopt;
  const Eigen::Vector3d terms = qr.solve(amplitude.cwiseAbs2());
  const double trial_square = terms(0) - bare * bare;
  if (!(trial_square > 0.0) || !(bare > 0.0)) return std::nullopt;
  const double trial = std::sqrt(trial_square);
  return Solved{bare / trial, std::atan2(terms(2), terms(1)),
                std::hypot(terms(1), terms(2)) / (2.0 * bare * trial)};
}

}  // namespace

std::optional<FourRunBalance> balance_by_four_runs(const AmplitudeRun& bare,
                                                   const std::vector<AmplitudeRun>& trials,
                                                   double trial_mass) {
  if (!(trial_mass > 0.0))
    throw std::invalid_argument("four-run balancing: the trial weight must have a mass");
  if (trials.size() < 3) return std::nullopt;
  const Eigen::Index count = std::ssize(trials);
  Eigen::MatrixXd shape(count, 3);
  Eigen::VectorXd amplitude(count), sigma(count + 1);
  for (Eigen::Index r = 0; r < count; ++r) {
    const AmplitudeRun& run = trials[static_cast<std::size_t>(r)];
    shape.row(r) << 1.0, std::cos(run.angle_rad), std::sin(run.angle_rad);
    amplitude(r) = run.amplitude;
    sigma(r) = run.sigma;
  }
  sigma(count) = bare.sigma;
  if (!(sigma.minCoeff() >= 0.0)) throw std::invalid_argument("four-run balancing: a sigma is negative");
  const auto best = solve(bare.amplitude, amplitude, shape);
  if (!best) return std::nullopt;

  // To first order in each amplitude.
  double ratio = 0.0, angle = 0.0, agreement = 0.0;
  for (Eigen::Index r = 0; r <= count; ++r) {
    if (sigma(r) == 0.0) continue;
    const double step = 1e-3 * sigma(r);
    Eigen::VectorXd moved = amplitude;
    if (r < count) moved(r) += step;
    const auto other = solve(bare.amplitude + (r < count ? 0.0 : step), moved, shape);
    if (!other) return std::nullopt;
    const double scale = sigma(r) / step;
    ratio += std::pow((other->ratio - best->ratio) * scale, 2);
    angle += std::pow(std::remainder(other->angle_rad - best->angle_rad, 2.0 * std::numbers::pi) * scale, 2);
    agreement += std::pow((other->agreement - best->agreement) * scale, 2);
  }
  if (std::sqrt(ratio) > 0.5 * best->ratio) return std::nullopt;
  if (std::abs(best->agreement - 1.0) > kDisagreement + 3.0 * std::sqrt(agreement)) return std::nullopt;
  const double opposite = std::remainder(best->angle_rad + std::numbers::pi, 2.0 * std::numbers::pi);
  return FourRunBalance{.mass = trial_mass * best->ratio,
                        .angle_rad = opposite < 0.0 ? opposite + 2.0 * std::numbers::pi : opposite,
                        .mass_sigma = trial_mass * std::sqrt(ratio),
                        .angle_sigma_rad = std::sqrt(angle),
                        .agreement = best->agreement};
}

}  // namespace roadbalance
