#pragma once

#include <vector>

#include "host/analysis/identify/estimators/estimator.hpp"
#include "host/analysis/identify/estimators/grouped.hpp"
#include "host/analysis/identify/estimators/line_phasors.hpp"

namespace roadbalance {

/// The correlation method, from which the covariance method starts: the acceleration of a wheel's carrier is
/// correlated with the cosine and sine of its angle, R(V) = E[z''(t) e^{-j alpha(t)}].  An unbalance answers
/// as
///
///     2 R(V_k) = Om_k^2 H(Om_k) U,
///
/// H the model's acceleration for a unit force; U is the least squares over the speeds.  Stiffnesses are
/// taken as known.
///
/// Another wheel's unbalance stays in R unless their frequencies differ long enough: over a time T wheels are
/// separated if |f_i - f_j| T >= 1.  Wheels that are not are refused.
///
/// Whether the force grows with the square of the speed is looked at: a diagnostic reports when the fitted
/// exponent is not 2 within two of its standard deviations, as with a tyre's radial force variation.
class CorrelationEstimator final : public Estimator {
 public:
  explicit CorrelationEstimator(const Question& question);

  void add(const Stretch& stretch) override;
  EstimatorAnswer solve() const override;

 private:
  void remark_on_growth(const BySpeed<LinePhasors>& drive, int wheel, EstimatorAnswer& answer) const;

  Question question_;
  LinearModel model_;
  LineCorrelator correlator_;
  Grouped<LinePhasors> sums_;
};

std::vector<EstimatorKind> correlation_kinds();

}  // namespace roadbalance
