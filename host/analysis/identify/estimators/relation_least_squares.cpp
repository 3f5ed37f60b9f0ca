#include "host/analysis/identify/estimators/relation_least_squares.hpp"

#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace roadbalance {
namespace {
/// For one row of the matrices at one speed and lag: [instrument x unknown] the relation for a unit of each,
/// and what the known leaves.
struct Equations {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
};

class Relation {
 public:
  Relation(const Question& question, const RelationOptions& options)
      : question_(question), options_(options), known_(question.known) {
    for (int i = 0; i < kUnknowns; ++i)
      if (question.asked[static_cast<std::size_t>(i)]) {
        unknown_.push_back(i);
        if (i >= kEstimatedUnbalance) continue;
        known_(kSpring + i) = 0.0;
        ParameterVector unit = ParameterVector::Zero();
        unit(kSpring + i) = 1.0;
        unit_.push_back(linear_model(question.geometry, unit));
      }
    model_ = linear_model(question.geometry, known_);
  }

  const std::vector<int>& unknown() const { return unknown_; }

  /// Left side of the relation, divided by the time.
  Equations equations(const RelationCovariances& sums, const LaggedCovariances& c, int row) const {
    const auto n = static_cast<Eigen::Index>(unknown_.size());
    Equations e{Eigen::MatrixXd::Zero(c.w2_z.rows(), n), -left_side(c, model_, row)};
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

  bool uses(int instrument, int row) const {
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

  /// H C_yu S' of this instrument is an unknown of the row.
  bool road_unknown(int instrument, int row) const {
    if (row < kBodyCoordinates) return false;
    const bool acceleration = instrument % kRelationSignals < kCoordinates;
    return options_.road == RelationRoad::kUnknown ||
           (options_.road == RelationRoad::kUnknownForAccelerations && acceleration);
  }

 private:
  Eigen::VectorXd left_side(const LaggedCovariances& c, const LinearModel& model, int row) const {
    Eigen::VectorXd side = c.w2_z * model.M.row(row).transpose() - c.w1_z * model.P.row(row).transpose() +
                           c.w0_z * model.Q.row(row).transpose();
    if (options_.road == RelationRoad::kMeasured) side -= c.w2_u * model.S.row(row).transpose();
    return side;
  }

  const Question& question_;
  const RelationOptions& options_;
  ParameterVector known_;
  LinearModel model_;
  std::vector<int> unknown_;
  std::vector<LinearModel> unit_;
};

/// Takes from the rows [speed x unknown] what a common unknown with coefficients v may explain.
void eliminate(const Eigen::VectorXd& v, Eigen::MatrixXd& rows) {
  rows -= v * (v.transpose() * rows).eval() / v.squaredNorm();
}

/// Mean power of each instrument over all speeds.
Eigen::VectorXd mean_power(const BySpeed<RelationCovariances>& sums) {
  Eigen::VectorXd power = Eigen::VectorXd::Zero(sums.at.begin()->second.power.size());
  double seconds = 0.0;
  for (const auto& [key, at] : sums.at) {
    power += at.power;
    seconds += at.seconds;
  }
  return power / seconds;
}

/// 1 / lambda_k of each speed.
Eigen::VectorXd road_growth(const BySpeed<RelationCovariances>& sums, double road_exponent) {
  Eigen::VectorXd growth(static_cast<Eigen::Index>(sums.at.size()));
  const double first_m_s = sums.at.begin()->second.speed_m_s();
  for (Eigen::Index k = 0; const auto& [key, at] : sums.at)
    growth(k++) = std::pow(at.speed_m_s() / first_m_s, road_exponent - 1.0);
  return growth;
}

/// All equations, [equation x unknown, then right side].
Eigen::MatrixXd all_equations(const BySpeed<RelationCovariances>& sums, const Relation& relation,
                              const Question& question, const RelationOptions& options) {
  const auto n = static_cast<Eigen::Index>(relation.unknown().size());
  const auto speeds = static_cast<Eigen::Index>(sums.at.size());
  const Eigen::VectorXd power = mean_power(sums);
  const Eigen::VectorXd growth = road_growth(sums, options.road_exponent);
  std::vector<Eigen::MatrixXd> blocks;  // of one row, lag and instrument: [speed x unknown, then right side]
  for (int row = 0; row < kCoordinates; ++row)
    for (std::size_t l = 0; l < sums.at.begin()->second.lag.size(); ++l) {
      std::vector<Equations> at_speed;
      for (const auto& [key, at] : sums.at) at_speed.push_back(relation.equations(at, at.lag[l], row));
      for (int i = 0; i < power.size(); ++i) {
        if (!relation.uses(i, row) || !(power(i) > 0.0)) continue;
        Eigen::MatrixXd block(speeds, n + 1);
        for (Eigen::Index k = 0; k < speeds; ++k) {
          const Equations& e = at_speed[static_cast<std::size_t>(k)];
          block.row(k) << e.A.row(i), e.b(i);
        }
        if (block.leftCols(n).isZero(0.0)) continue;
        if (options.scaled) block /= question.known(row) * std::sqrt(power(i));
        if (relation.road_unknown(i, row)) eliminate(growth, block);
        blocks.push_back(std::move(block));
      }
    }
  Eigen::MatrixXd all(speeds * static_cast<Eigen::Index>(blocks.size()), n + 1);
  for (std::size_t b = 0; b < blocks.size(); ++b)
    all.middleRows(speeds * static_cast<Eigen::Index>(b), speeds) = blocks[b];
  return all;
}

}  // namespace

std::optional<UnknownVector> solve_relation(const BySpeed<RelationCovariances>& sums,
                                            const Question& question, const RelationOptions& options) {
  if (sums.at.empty()) return std::nullopt;
  const Relation relation(question, options);
  const Eigen::MatrixXd all = all_equations(sums, relation, question, options);
  const Eigen::Index n = all.cols() - 1;
  std::vector<Eigen::Index>
      determined;  // columns that occur: the unbalance of a wheel without reference does not
  for (Eigen::Index p = 0; p < n; ++p)
    if (all.col(p).size() > 0 && !all.col(p).isZero(0.0)) determined.push_back(p);
  if (determined.empty() || !all.allFinite()) return std::nullopt;
  const Eigen::VectorXd size = all(Eigen::all, determined).colwise().norm();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(all(Eigen::all, determined) *
                                                       size.cwiseInverse().asDiagonal());
  if (qr.rank() < size.size()) return std::nullopt;
  const Eigen::VectorXd solution = qr.solve(all.col(n)).cwiseQuotient(size);
  UnknownVector x = known_unknowns(question);
  for (const int i : relation.unknown()) x(i) = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t p = 0; p < determined.size(); ++p)
    x(relation.unknown()[static_cast<std::size_t>(determined[p])]) = solution(static_cast<Eigen::Index>(p));
  return x;
}

}  // namespace roadbalance
