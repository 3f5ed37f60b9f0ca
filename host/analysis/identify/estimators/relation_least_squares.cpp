#include "host/analysis/identify/estimators/relation_least_squares.hpp"

#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <vector>

#include "host/analysis/identify/estimators/unknown_road.hpp"

namespace roadbalance {
namespace {

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

/// All equations, [equation x unknown, then right side].
///
/// Divided by the mass of their row and the rms of their instrument w'' over all speeds together, so that all
/// are accelerations.
Eigen::MatrixXd all_equations(const BySpeed<RelationCovariances>& sums, const RelationEquations& relation,
                              const Question& question) {
  const auto n = static_cast<Eigen::Index>(relation.unknown().size());
  const auto speeds = static_cast<Eigen::Index>(sums.at.size());
  const Eigen::VectorXd power = mean_power(sums);
  std::vector<Eigen::MatrixXd> blocks;  // of one row, lag and instrument: [speed x unknown, then right side]
  for (int row = 0; row < kCoordinates; ++row)
    for (std::size_t l = 0; l < sums.at.begin()->second.lag.size(); ++l) {
      std::vector<RelationEquations::Equations> at_speed;
      for (const auto& [key, at] : sums.at) at_speed.push_back(relation.equations(at, at.lag[l], row));
      for (int i = 0; i < power.size(); ++i) {
        if (!relation.uses(i, row) || !(power(i) > 0.0)) continue;
        Eigen::MatrixXd block(speeds, n + 1);
        for (Eigen::Index k = 0; k < speeds; ++k) {
          const RelationEquations::Equations& e = at_speed[static_cast<std::size_t>(k)];
          block.row(k) << e.A.row(i), e.b(i);
        }
        if (block.leftCols(n).isZero(0.0)) continue;
        blocks.push_back(block / (question.known(row) * std::sqrt(power(i))));
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
  if (options.road == RelationRoad::kUnknown) {
    const auto unknown_road = UnknownRoad::fit(sums, question, options);
    return unknown_road ? unknown_road->solve(sums) : std::nullopt;
  }
  const RelationEquations relation(question, options);
  const Eigen::MatrixXd all = all_equations(sums, relation, question);
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
