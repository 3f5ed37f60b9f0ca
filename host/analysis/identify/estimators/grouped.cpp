#include "host/analysis/identify/estimators/grouped.hpp"

#include <limits>

namespace roadbalance {

UnknownVector known_unknowns(const Question& question) {
  UnknownVector x = UnknownVector::Zero();
  x.head<kEstimatedUnbalance>() = question.known.segment<kEstimatedUnbalance>(kSpring);
  return x;
}

EstimatorAnswer judged(const Question& question, const std::optional<UnknownVector>& x,
                       const std::optional<UnknownMatrix>& covariance) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  EstimatorAnswer answer;
  answer.x = known_unknowns(question);
  for (int i = 0; i < kUnknowns; ++i) {
    if (!question.asked[static_cast<std::size_t>(i)]) continue;
    answer.x(i) = x ? (*x)(i) : kNone;
    for (int j = 0; j < kUnknowns; ++j)
      if (question.asked[static_cast<std::size_t>(j)])
        answer.covariance(i, j) = x && covariance ? (*covariance)(i, j) : kNone;
  }
  if (x && !covariance)
    answer.diagnostics.emplace_back("the drive is too short to tell how sure the estimate is");
  return answer;
}

}  // namespace roadbalance
