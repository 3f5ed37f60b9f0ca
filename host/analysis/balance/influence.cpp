#include "host/analysis/balance/influence.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;

void check(const std::vector<InfluenceRun>& runs) {
  if (runs.empty()) throw std::invalid_argument("balancing by influence: there is no run");
  const InfluenceRun& first = runs.front();
  if (first.weight.size() < 1 || first.observed.size() < 1)
    throw std::invalid_argument("balancing by influence: it needs a plane and something observed");
  for (const InfluenceRun& run : runs) {
    if (run.weight.size() != first.weight.size() || run.observed.size() != first.observed.size() ||
        run.variance.size() != run.observed.size())
      throw std::invalid_argument("balancing by influence: runs differ in their planes or observations");
    if (!(run.variance.minCoeff() > 0.0))
      throw std::invalid_argument("balancing by influence: a variance is not positive");
    if (!(run.phase_sigma_rad >= 0.0))
      throw std::invalid_argument("balancing by influence: a phase sigma is negative");
  }
}

struct Fit {
  Eigen::MatrixXcd influence;
  Eigen::VectorXcd bare, correction;
  /// [observation] of 1 + plane by run: what a change of what a run observed does to bare and influence.
  std::vector<Eigen::MatrixXcd> from_observed;
};

/// Least squares; nothing if the left side does not determine all unknowns.
std::optional<Eigen::MatrixXcd> solve(const Eigen::MatrixXcd& left, const Eigen::MatrixXcd& right) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXcd> qr(left);
  qr.setThreshold(1e-6);
  if (qr.rank() < left.cols()) return std::nullopt;
  return qr.solve(right);
}

std::optional<Fit> fit(const std::vector<InfluenceRun>& runs) {
  const Eigen::Index planes = runs.front().weight.size(), observations = runs.front().observed.size();
  const Eigen::Index count = std::ssize(runs);
  Fit result{Eigen::MatrixXcd(observations, planes), Eigen::VectorXcd(observations), {}, {}};
  for (Eigen::Index o = 0; o < observations; ++o) {
    Eigen::MatrixXcd left(count, planes + 1), weighting = Eigen::MatrixXcd::Zero(count, count);
    Eigen::VectorXcd observed(count);
    for (Eigen::Index r = 0; r < count; ++r) {
      const InfluenceRun& run = runs[static_cast<std::size_t>(r)];
      const double sigma = std::sqrt(run.variance(o));
      left(r, 0) = 1.0 / sigma;
      left.row(r).tail(planes) = run.weight.transpose() / sigma;
      weighting(r, r) = 1.0 / sigma;
      observed(r) = run.observed(o);
    }
    auto solved = solve(left, weighting);
    if (!solved) return std::nullopt;
    const Eigen::VectorXcd terms = *solved * observed;
    result.bare(o) = terms(0);
    result.influence.row(o) = terms.tail(planes).transpose();
    result.from_observed.push_back(std::move(*solved));
  }
  const auto weights = correction_by_influence(result.influence, result.bare);
  if (!weights) return std::nullopt;
  result.correction = *weights;
  return result;
}

/// Sigma of each part of the correction weights, by the mean of the two parts' variances, to first order.
///
/// With N = A* A, residual r = b + A w and changes db, dA of an observation's row, N dw = -dA* r - A* (db +
/// dA w): one share goes with what was observed, the other with its conjugate.
Eigen::VectorXd sigma_of(const std::vector<InfluenceRun>& runs, const Fit& best) {
  const Eigen::MatrixXcd& a = best.influence;
  const Eigen::MatrixXcd normal_inverse = (a.adjoint() * a).inverse();
  const Eigen::VectorXcd residual = best.bare + a * best.correction;
  const Eigen::Index planes = a.cols();
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(planes);
  for (Eigen::Index r = 0; r < std::ssize(runs); ++r) {
    const InfluenceRun& run = runs[static_cast<std::size_t>(r)];
    Eigen::VectorXcd turned = Eigen::VectorXcd::Zero(planes);  // by all phases together
    for (Eigen::Index o = 0; o < run.observed.size(); ++o) {
      const Eigen::VectorXcd change = best.from_observed[static_cast<std::size_t>(o)].col(r);
      const Eigen::VectorXcd of_influence = change.tail(planes);
      const Complex direct = change(0) + (of_influence.transpose() * best.correction).value();
      const Eigen::VectorXcd with = -normal_inverse * (a.row(o).adjoint() * direct);
      const Eigen::VectorXcd with_conjugate = -normal_inverse * (of_influence.conjugate() * residual(o));
      variance += 0.5 * run.variance(o) * (with.cwiseAbs2() + with_conjugate.cwiseAbs2());
      const Complex aside = Complex(0.0, run.phase_sigma_rad) * run.observed(o);
      turned += with * aside + with_conjugate * std::conj(aside);
    }
    variance += 0.5 * turned.cwiseAbs2();
  }
  return variance.cwiseSqrt();
}

/// Whether what a weight does stands out of what the runs scatter, in every plane.
bool tells_influences(const std::vector<InfluenceRun>& runs, const Fit& best) {
  constexpr double kLeast = 4.0;  // times the variance: of scatter alone one observation is so large in 2 %
  for (Eigen::Index p = 0; p < best.influence.cols(); ++p) {
    double scatter = 0.0;
    for (Eigen::Index o = 0; o < best.influence.rows(); ++o)
      for (Eigen::Index r = 0; r < std::ssize(runs); ++r)
        scatter += std::norm(best.from_observed[static_cast<std::size_t>(o)](1 + p, r)) *
                   runs[static_cast<std::size_t>(r)].variance(o);
    if (best.influence.col(p).squaredNorm() < kLeast * scatter) return false;
  }
  return true;
}

/// Chance of chi^2 with 2 m degrees of freedom: e^-x/2 sum_{k < m} (x/2)^k / k!.
double chance_of_chi_square(double x, Eigen::Index m) {
  double term = std::exp(-0.5 * x), sum = 0.0;
  for (Eigen::Index k = 0; k < m; ++k) {
    sum += term;
    term *= 0.5 * x / static_cast<double>(k + 1);
  }
  return sum;
}

double chance_of_contradictions(const std::vector<InfluenceRun>& runs, const Fit& best) {
  const Eigen::Index beyond = std::ssize(runs) - best.influence.cols() - 1;
  if (beyond == 0) return 1.0;
  double square = 0.0;
  for (const InfluenceRun& run : runs) {
    const Eigen::VectorXcd off = run.observed - best.bare - best.influence * run.weight;
    const double turned = run.phase_sigma_rad * run.phase_sigma_rad;
    for (Eigen::Index o = 0; o < off.size(); ++o)
      square += 2.0 * std::norm(off(o)) / (run.variance(o) + 2.0 * turned * std::norm(run.observed(o)));
  }
  return chance_of_chi_square(square, beyond * best.bare.size());
}

double condition_of(const Eigen::MatrixXcd& influence) {
  const Eigen::VectorXd singular = Eigen::JacobiSVD<Eigen::MatrixXcd>(influence).singularValues();
  return singular(0) / singular(singular.size() - 1);
}

}  // namespace

PlaneCorrection plane_correction(std::complex<double> weight_g, double sigma_g) {
  const double angle = std::arg(weight_g), mass = std::abs(weight_g);
  return {mass, angle < 0.0 ? angle + kTurn : angle, sigma_g,
          mass > sigma_g ? std::asin(sigma_g / mass) : std::numbers::pi};
}

std::optional<Eigen::VectorXcd> correction_by_influence(const Eigen::MatrixXcd& influence,
                                                        const Eigen::VectorXcd& bare) {
  const auto weights = solve(influence, -bare);
  if (!weights) return std::nullopt;
  return Eigen::VectorXcd(weights->col(0));
}

std::optional<InfluenceBalance> balance_by_influence(const std::vector<InfluenceRun>& runs) {
  check(runs);
  const auto best = fit(runs);
  if (!best || !tells_influences(runs, *best)) return std::nullopt;
  InfluenceBalance balance{best->influence,
                           best->bare,
                           best->correction,
                           sigma_of(runs, *best),
                           {},
                           0.0,
                           0.0,
                           chance_of_contradictions(runs, *best),
                           condition_of(best->influence)};
  balance.residual = best->bare + best->influence * best->correction;
  const double root = std::sqrt(static_cast<double>(balance.bare.size()));
  balance.rms_before = balance.bare.norm() / root;
  balance.rms_after = balance.residual.norm() / root;
  return balance;
}

}  // namespace roadbalance
