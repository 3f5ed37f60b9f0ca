#include "host/analysis/identify/estimators/chassis.hpp"

#include <limits>
#include <memory>

namespace roadbalance {
namespace {

Question of_suspension(Question question) {
  question.asked &= suspension_unknowns();
  return question;
}

}  // namespace

ChassisEstimator::ChassisEstimator(const Question& question)
    : question_(question), suspension_(of_suspension(question), {.tyre = TyreFrom::kInstrument}) {}

void ChassisEstimator::add(const Stretch& stretch) {
  Stretch without_angles = stretch;
  without_angles.omega.setZero();  // no unbalance acts on the body
  suspension_.add(without_angles);
}

EstimatorAnswer ChassisEstimator::solve() const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  EstimatorAnswer answer = suspension_.solve();
  bool others = false;
  for (int i = kEstimatedTyre; i < kUnknowns; ++i) {
    if (!question_.asked[static_cast<std::size_t>(i)]) continue;
    others = true;
    answer.x(i) = kNone;
    answer.covariance.row(i).setConstant(kNone);
    answer.covariance.col(i).setConstant(kNone);
  }
  if (others) answer.diagnostics.emplace_back("the body's rows tell springs, dampers and stabilisers alone");
  return answer;
}

std::vector<EstimatorKind> chassis_kinds() {
  return {{"chassis", "springs, dampers and stabilisers from the body's motion alone", false,
           [](const Question& question) -> std::unique_ptr<Estimator> {
             return std::make_unique<ChassisEstimator>(question);
           }}};
}

}  // namespace roadbalance
