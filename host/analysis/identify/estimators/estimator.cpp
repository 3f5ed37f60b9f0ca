#include "host/analysis/identify/estimators/estimator.hpp"

#include <utility>

#include "common/config/section.hpp"
#include "host/analysis/identify/estimators/chassis.hpp"
#include "host/analysis/identify/estimators/correlation.hpp"
#include "host/analysis/identify/estimators/harmonic_ml.hpp"
#include "host/analysis/identify/estimators/paper.hpp"
#include "host/analysis/identify/estimators/two_stage.hpp"

namespace roadbalance {

bool Question::asks_for_suspension() const {
  for (std::size_t i = 0; i < kEstimatedTyre; ++i)
    if (asked[i]) return true;
  return false;
}

std::span<const EstimatorKind> estimators() {
  static const std::vector<EstimatorKind> kAll = [] {
    std::vector<EstimatorKind> all;
    for (const auto kinds :
         {paper_kinds, own_past_kinds, harmonic_kinds, correlation_kinds, two_stage_kinds, chassis_kinds})
      for (EstimatorKind& kind : kinds()) all.push_back(std::move(kind));
    return all;
  }();
  return kAll;
}

const EstimatorKind& estimator_kind(const std::string& name) {
  std::string names;
  for (const EstimatorKind& kind : estimators()) {
    if (kind.name == name) return kind;
    names += (names.empty() ? "" : ", ") + kind.name;
  }
  throw ConfigError("estimator " + name + ": there is none of this name; allowed: " + names);
}

std::unique_ptr<Estimator> make_estimator(const std::string& name, const Question& question) {
  return estimator_kind(name).make(question);
}

}  // namespace roadbalance
