#pragma once

#include <vector>

#include "host/analysis/identify/estimators/estimator.hpp"
#include "host/analysis/identify/estimators/relation_covariances.hpp"
#include "host/analysis/identify/estimators/relation_least_squares.hpp"

namespace roadbalance {

/// The covariance method: sample covariances of filtered with measured signals at some lags, at several
/// speeds, and relation (2) between them solved for all that is asked (27).
///
/// Memory: for each speed class and jackknife group 57 instruments (order 5) times 19 signals, times 3, a
/// lag.
class RelationEstimator final : public Estimator {
 public:
  /// @throws std::invalid_argument as RelationFilter
  RelationEstimator(Question question, RelationOptions options);

  void add(const Stretch& stretch) override;
  EstimatorAnswer solve() const override;

  const RelationOptions& options() const { return options_; }

 private:
  EstimatorAnswer solve_directly() const;
  EstimatorAnswer solve_with_unknown_road() const;

  Question question_;
  RelationOptions options_;
  RelationFilter filter_;
  Grouped<RelationCovariances> sums_;
};

/// The paper's own, and those with the road measured.
///
/// paper, paper-lags and paper-own are (25)-(27) with lambda from the current estimate, the filter and the
/// road (UnknownRoad), and equations weighed by their scatter.
std::vector<EstimatorKind> paper_kinds();

/// Without any unknown of the road: a wheel's past does not depend on the road to come, and white noise of
/// the sensors drops out as well.
///
/// E[w''(t) u(t + tau)] = 0 for tau > 0 if u' is white and w'' a causal filter with two zeros at rest.  The
/// contact patch leaves exp(-w2 tau), w2 = 2 pi 4 V: lag 0 is not clean, 10 ms is.  Negative lags are wrong:
/// the future depends on the road.
std::vector<EstimatorKind> own_past_kinds();

}  // namespace roadbalance
