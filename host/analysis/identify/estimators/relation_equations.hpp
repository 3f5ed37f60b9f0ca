#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/analysis/identify/estimators/estimator.hpp"
#include "host/analysis/identify/estimators/relation_covariances.hpp"

namespace roadbalance {

/// Which instruments a wheel's row of (2) uses.  The body's rows always use all.
enum class RelationInstruments {
  kAll,     ///< accelerations of all coordinates, angles of all wheels asked for, road where measured
  kOwn,     ///< the wheel's own acceleration, angle and road
  kAngles,  ///< its angle alone
};

/// Stand-in for H C_yu.
enum class RelationRoad {
  kUnknown,  ///< unknown for every acceleration and lag; lambda_k leads from speed to speed
  kNone,     ///< 0: instruments of the past do not depend on the road to come
  kMeasured,
};

struct RelationOptions {
  RelationInstruments instruments = RelationInstruments::kAll;
  RelationRoad road = RelationRoad::kUnknown;
  double road_exponent = 2.0;  ///< w of the road's spectrum, ~ 1 / frequency^w; asked with the road unknown
  /// Filter and lags that the covariances are of; asked with the road unknown.
  RelationFilter::Options filter{};
};

/// Relation (2) as equations that are linear in what is asked.
class RelationEquations {
 public:
  /// For one row of the matrices at one speed and lag, A x = b, x the unknowns in the order of unknown().
  struct Equations {
    Eigen::MatrixXd A;  ///< [instrument x unknown] of a unit of each
    Eigen::VectorXd b;  ///< what the known leaves
  };

  RelationEquations(const Question& question, const RelationOptions& options);

  /// Places in UnknownVector, ascending.
  const std::vector<int>& unknown() const { return unknown_; }

  /// @param row  of the matrices, 0 .. kCoordinates - 1
  Equations equations(const RelationCovariances& sums, const LaggedCovariances& c, int row) const;

  /// @param instrument  row of LaggedCovariances
  bool uses(int instrument, int row) const;

 private:
  Eigen::VectorXd left_side(const LaggedCovariances& c, const LinearModel& model, int row) const;

  const Question& question_;
  const RelationOptions& options_;
  LinearModel known_;
  std::vector<int> unknown_;
  std::vector<LinearModel> unit_;  ///< of each unknown stiffness and damper, in this order
};

}  // namespace roadbalance
