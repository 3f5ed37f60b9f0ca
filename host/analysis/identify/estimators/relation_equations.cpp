#include "host/analysis/identify/estimators/relation_equations.hpp"

namespace roadbalance {

RelationEquations::RelationEquations(const Question& question, const RelationOptions& options)
    : question_(question), options_(options) {
  ParameterVector known = question.known;
  for (int i = 0; i < kUnknowns; ++i)
    if (question.asked[static_cast<std::size_t>(i)]) {
      unknown_.push_back(i);
      if (i >= kEstimatedUnbalance) continue;
      known(kSpring + i) = 0.0;
      ParameterVector unit = ParameterVector::Zero();
      unit(kSpring + i) = 1.0;
      unit_.push_back(linear_model(question.geometry, unit));
    }
  known_ = linear_model(question.geometry, known);
}

RelationEquations::Equations RelationEquations::equations(const RelationCovariances& sums,
                                                          const LaggedCovariances& c, int row) const {
  const auto n = static_cast<Eigen::Index>(unknown_.size());
  Equations e{Eigen::MatrixXd::Zero(c.w2_z.rows(), n), -left_side(c, known_, row)};
  for (Eigen::Index p = 0; p < n; ++p) {
    const int i = unknown_[static_cast<std::size_t>(p)];
    if (i < kEstimatedUnbalance) {
      e.A.col(p) = left_side(c, unit_[static_cast<std::size_t>(p)], row);
      continue;
    }
    // F_z = Re{U Om^2 e^{j alpha}} = Om^2 (Re U cos alpha - Im U sin alpha) on the wheel's own row.
    const int part = i - kEstimatedUnbalance, wheel = part / 2;
    if (row == kBodyCoordinates + wheel) e.A.col(p) = (part % 2 == 0 ? -1.0 : 1.0) * c.w2_d.col(part);
  }
  e.A /= sums.seconds;
  e.b /= sums.seconds;
  return e;
}

bool RelationEquations::uses(int instrument, int row) const {
  const int signal = instrument % kRelationSignals, wheel = row - kBodyCoordinates;
  const bool acceleration = signal < kCoordinates, angle = !acceleration && signal < kSignals;
  const int its_wheel = acceleration ? signal - kBodyCoordinates
                        : angle      ? (signal - kCoordinates) / 2
                                     : signal - kSignals;
  if (!acceleration && !angle && options_.road != RelationRoad::kMeasured) return false;
  if (angle && !question_.asks_for_unbalance(its_wheel)) return false;
  if (wheel < 0 || options_.instruments == RelationInstruments::kAll) return true;
  return its_wheel == wheel && (angle || options_.instruments == RelationInstruments::kOwn);
}

Eigen::VectorXd RelationEquations::left_side(const LaggedCovariances& c, const LinearModel& model,
                                             int row) const {
  Eigen::VectorXd side = c.w2_z * model.M.row(row).transpose() - c.w1_z * model.P.row(row).transpose() +
                         c.w0_z * model.Q.row(row).transpose();
  if (options_.road == RelationRoad::kMeasured) side -= c.w2_u * model.S.row(row).transpose();
  return side;
}

}  // namespace roadbalance
