#include "host/identify/estimator.hpp"

#include "common/config/section.hpp"

namespace roadbalance {

bool Question::asks_for_suspension() const {
  for (std::size_t i = 0; i < kEstimatedTyre; ++i)
    if (asked[i]) return true;
  return false;
}

std::span<const EstimatorKind> estimators() {
  static const std::vector<EstimatorKind> kAll{};
  return kAll;
}

std::unique_ptr<Estimator> make_estimator(const std::string& name, const Question& question) {
  std::string names;
  for (const EstimatorKind& kind : estimators()) {
    if (kind.name == name) return kind.make(question);
    names += (names.empty() ? "" : ", ") + kind.name;
  }
  throw ConfigError("estimator " + name + ": there is none of this name; allowed: " + names);
}

}  // namespace roadbalance
