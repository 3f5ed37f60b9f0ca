#pragma once

#include <vector>

#include "host/analysis/identify/drive_posterior.hpp"
#include "host/analysis/identify/estimators/estimator.hpp"

namespace roadbalance {

/// The drive's posterior (drive_posterior.hpp) behind the estimators' interface.  The unbalance that it
/// answers with is the correction for the speeds driven; unbalance alone and tyre's force are in the
/// diagnostics.  What the question takes for known apart from tyres and suspension comes with its sigma from
/// Question::prior.
class Posterior final : public Estimator {
 public:
  /// @throws ConfigError if the question has no prior
  explicit Posterior(const Question& question);

  void add(const Stretch& stretch) override { drive_.add(stretch); }
  EstimatorAnswer solve() const override;

 private:
  Question question_;
  DrivePosterior drive_;
};

std::vector<EstimatorKind> posterior_kinds();

}  // namespace roadbalance
