#include "host/balance/influence.hpp"

#include <Eigen/QR>
#include <cmath>
#include <complex>
#include <stdexcept>

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
  }
}

struct Fit {
  Eigen::MatrixXcd influence;
  Eigen::VectorXcd bare, correction;
};

/// Least squares; nothing if the left side does not tell all unknowns.
std::optional<Eigen::MatrixXcd> solve(const Eigen::MatrixXcd& left, const Eigen::MatrixXcd& right) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXcd> qr(left);
  qr.setThreshold(1e-6);
  if (qr.rank() < left.cols()) return std::nullopt;
  return qr.solve(right);
}

/// @param change  of observation `at` of run `changed`, so that derivatives can be had
std::optional<Fit> fit(const std::vector<InfluenceRun>& runs, std::size_t changed, Eigen::Index at,
                       Complex change) {
  const Eigen::Index planes = runs.front().weight.size(), observations = runs.front().observed.size();
  const Eigen::Index count = std::ssize(runs);
  Fit result{Eigen::MatrixXcd(observations, planes), Eigen::VectorXcd(observations), {}};
  for (Eigen::Index o = 0; o < observations; ++o) {
    Eigen::MatrixXcd left(count, planes + 1);
    Eigen::VectorXcd right(count);
    for (Eigen::Index r = 0; r < count; ++r) {
      const InfluenceRun& run = runs[static_cast<std::size_t>(r)];
      const double sigma = std::sqrt(run.variance(o));
      const bool is_changed = static_cast<std::size_t>(r) == changed && o == at;
      left(r, 0) = 1.0 / sigma;
      left.row(r).tail(planes) = run.weight.transpose() / sigma;
      right(r) = (run.observed(o) + (is_changed ? change : Complex(0.0))) / sigma;
    }
    const auto solved = solve(left, right);
    if (!solved) return std::nullopt;
    result.bare(o) = (*solved)(0, 0);
    result.influence.row(o) = solved->col(0).tail(planes).transpose();
  }
  const auto weights = solve(result.influence, -result.bare);
  if (!weights) return std::nullopt;
  result.correction = weights->col(0);
  return result;
}

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// Of each part of the correction weights: the mean of the two parts' variances, to first order.
Eigen::VectorXd sigma_of(const std::vector<InfluenceRun>& runs, const Fit& best) {
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(best.correction.size());
  for (std::size_t r = 0; r < runs.size(); ++r)
    for (Eigen::Index o = 0; o < runs[r].observed.size(); ++o) {
      const double part = std::sqrt(0.5 * runs[r].variance(o));
      const double step = 1e-3 * part;
      for (const Complex change : {Complex(step, 0.0), Complex(0.0, step)}) {
        const auto moved = fit(runs, r, o, change);
        if (!moved) continue;
        variance += 0.5 * ((moved->correction - best.correction) * (part / step)).cwiseAbs2();
      }
    }
  return variance.cwiseSqrt();
}

}  // namespace

std::optional<InfluenceBalance> balance_by_influence(const std::vector<InfluenceRun>& runs) {
  check(runs);
  const auto best = fit(runs, kNone, 0, 0.0);
  if (!best) return std::nullopt;
  InfluenceBalance balance{
      best->influence, best->bare, best->correction, sigma_of(runs, *best), {}, 0.0, 0.0};
  balance.residual = best->bare + best->influence * best->correction;
  const double root = std::sqrt(static_cast<double>(balance.bare.size()));
  balance.rms_before = balance.bare.norm() / root;
  balance.rms_after = balance.residual.norm() / root;
  return balance;
}

}  // namespace roadbalance
