#pragma once

#include <bitset>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/estimate.hpp"
#include "host/analysis/identify/stretch.hpp"

namespace roadbalance {

/// The unknowns asked for, and the values that an estimator may take as known.
struct Question {
  Geometry geometry;
  /// Values of all parameters; those asked for are where a search begins.
  ParameterVector known = ParameterVector::Zero();
  /// Places in UnknownVector; both parts of an unbalance together.
  std::bitset<kUnknowns> asked;

  bool asks_for_tyre(int wheel) const { return asked[static_cast<std::size_t>(kEstimatedTyre + wheel)]; }
  bool asks_for_unbalance(int wheel) const {
    return asked[static_cast<std::size_t>(kEstimatedUnbalance + 2 * wheel)];
  }
  /// Springs, dampers and stabilisers: any of them.
  bool asks_for_suspension() const;
};

struct EstimatorAnswer {
  /// Unknowns not asked for are as known; an unbalance not asked for is 0.  NaN: this drive does not
  /// determine it.
  UnknownVector x = UnknownVector::Zero();
  /// Covariance of x; rows of unknowns not asked for are 0, of those that the estimator cannot judge NaN.
  UnknownMatrix covariance = UnknownMatrix::Zero();
  /// Sentences for the driver: why something is not determined, or what an answer rests on.
  std::vector<std::string> diagnostics;
};

/// One way to find unknowns of the car from stretches of steady driving.
///
/// Every estimator of the project stands behind this, so that one study measures them all and one recorded
/// drive can be put to each.  Memory does not grow with the length of what was added, unless the estimator's
/// header states it.
class Estimator {
 public:
  virtual ~Estimator() = default;

  /// Stretches in any order; all of one rate.
  virtual void add(const Stretch& stretch) = 0;
  /// From all that was added; may be asked again and again.
  virtual EstimatorAnswer solve() const = 0;
};

/// A way there is, under its name for `rb identify --estimator` and the studies.
struct EstimatorKind {
  std::string name;
  std::string what;            ///< one line
  bool road_measured = false;  ///< it needs Stretch::road_m
  std::unique_ptr<Estimator> (*make)(const Question& question);
};

/// In the order in which they are listed: the paper's first.
std::span<const EstimatorKind> estimators();

/// @throws ConfigError naming the estimators there are
const EstimatorKind& estimator_kind(const std::string& name);
/// @throws as estimator_kind
std::unique_ptr<Estimator> make_estimator(const std::string& name, const Question& question);

}  // namespace roadbalance
