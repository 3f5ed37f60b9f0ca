#pragma once

#include <vector>

#include "host/analysis/identify/estimators/two_stage.hpp"

namespace roadbalance {

/// Springs, dampers and stabilisers alone, from the body's rows of (2), where no road and no unbalance acts:
/// the product's first step (solve_suspension), of stretches as TwoStage cuts them.
class ChassisEstimator final : public Estimator {
 public:
  explicit ChassisEstimator(const Question& question);

  void add(const Stretch& stretch) override;
  EstimatorAnswer solve() const override;

 private:
  Question question_;
  TwoStage suspension_;
};

std::vector<EstimatorKind> chassis_kinds();

}  // namespace roadbalance
