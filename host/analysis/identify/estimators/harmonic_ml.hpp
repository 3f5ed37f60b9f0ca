#pragma once

#include <vector>

#include "host/analysis/identify/estimators/estimator.hpp"
#include "host/analysis/identify/estimators/grouped.hpp"
#include "host/analysis/identify/estimators/line_phasors.hpp"

namespace roadbalance {

/// Maximum likelihood of the lines alone, as an output error: tyre stiffnesses and unbalances for which the
/// model's accelerations at the wheels' orders come nearest to the measured ones,
///
///     min over ct, U of  sum_k tr( K_k^-1 R_k conj(S_k)^-1 R_k^H ),   R_k = Z_k - sum_i C_i G_i(Om_k; ct)
///     U_i
///
/// at the speeds k, S_k the spectrum of the road's accelerations measured beside the lines
/// (line_phasors.hpp). U is linear and eliminated; ct is searched within 30 % of what is known, for further
/// off there are local minima.  The lines hold little of ct, and the road's spectrum nothing here.
///
/// The covariance is the inverse of Fisher's information, 2 Re J^H W J.
class HarmonicLikelihood final : public Estimator {
 public:
  explicit HarmonicLikelihood(const Question& question);

  void add(const Stretch& stretch) override;
  EstimatorAnswer solve() const override;

 private:
  Question question_;
  LineCorrelator correlator_;
  Grouped<LinePhasors> sums_;
};

/// harmonic: the angles as instruments of the relation, by least squares; harmonic-ml.
std::vector<EstimatorKind> harmonic_kinds();

}  // namespace roadbalance
