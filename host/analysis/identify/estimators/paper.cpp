#include "host/analysis/identify/estimators/paper.hpp"

#include <algorithm>
#include <memory>
#include <utility>

namespace roadbalance {
namespace {

template <auto Filter, auto Relation>
std::unique_ptr<Estimator> make_paper(const Question& question) {
  return std::make_unique<RelationEstimator>(question, Filter(), Relation);
}

RelationFilter::Options one_lag() {
  return {};
}
RelationFilter::Options lags() {
  return {.lags_s = {0.0, 0.010, 0.020, 0.040}};
}
RelationFilter::Options road_lags() {
  return {.lags_s = {0.0, 0.004, 0.010}};
}
RelationFilter::Options windowed() {
  return {.windowed = true};
}
RelationFilter::Options past() {
  return {.lags_s = {0.010, 0.020, 0.040}};
}
RelationFilter::Options windowed_past() {
  return {.lags_s = {0.010, 0.020, 0.040}, .windowed = true};
}

using Instruments = RelationInstruments;
using Road = RelationRoad;
constexpr RelationOptions kPaper{.instruments = Instruments::kAll, .road = Road::kUnknown, .scaled = false};
constexpr RelationOptions kOwn{
    .instruments = Instruments::kOwn, .road = Road::kUnknownForAccelerations, .scaled = false};
constexpr RelationOptions kRoad{.instruments = Instruments::kAll, .road = Road::kMeasured};
constexpr RelationOptions kPast{.instruments = Instruments::kOwn, .road = Road::kNone};

}  // namespace

RelationEstimator::RelationEstimator(Question question, RelationFilter::Options filter,
                                     RelationOptions relation)
    : question_(std::move(question)), filter_(std::move(filter)), relation_(relation) {}

void RelationEstimator::add(const Stretch& stretch) {
  if (relation_.road == Road::kMeasured && stretch.road_m.cols() == 0) return;
  filter_.parts(stretch,
                [this](double speed_m_s, const RelationCovariances& part) { sums_.add(speed_m_s, part); });
}

EstimatorAnswer RelationEstimator::solve() const {
  EstimatorAnswer answer = sums_.solve(question_, [this](const BySpeed<RelationCovariances>& sums) {
    return solve_relation(sums, question_, relation_);
  });
  const bool few_tell_it = relation_.road == Road::kUnknown ||
                           relation_.road == Road::kUnknownForAccelerations ||
                           relation_.instruments == Instruments::kAngles;
  if (few_tell_it)
    answer.diagnostics.emplace_back(
        "± is the scatter alone: the road's share in the equations pulls stiffness and unbalance off beyond "
        "it, "
        "the more the shorter the drive");
  if (relation_.road == Road::kMeasured && !question_.known.segment<kWheels>(kTyreDamper).isZero(0.0))
    answer.diagnostics.emplace_back(
        "the damping of the tyres in vehicle.toml (tyre_damper_n_s_m) acts on the road's rate of change, "
        "too, "
        "which these equations leave out: stiffness and unbalance are off beyond ±");
  if (answer.x.allFinite()) return answer;
  const std::size_t speeds = sums_.speeds();
  if (speeds == 0)
    answer.diagnostics.emplace_back(
        relation_.road == Road::kMeasured ? "no steady driving over a measured road" : "no steady driving");
  else if (relation_.road == Road::kUnknown && speeds < 2)
    answer.diagnostics.emplace_back(
        "the road is not measured and only speeds tell it from the unbalance: drive at two speeds or more");
  else
    answer.diagnostics.emplace_back(
        "the drive does not tell all that was asked; a wheel without angle has no unbalance");
  return answer;
}

std::vector<EstimatorKind> paper_kinds() {
  return {
      {"paper", "the paper: all covariances at lag 0, those with the road unknown", false,
       make_paper<one_lag, kPaper>},
      {"paper-lags", "the paper with lags of 0, 10, 20 and 40 ms", false, make_paper<lags, kPaper>},
      {"paper-own", "the same, instruments the wheel's own acceleration and angle", false,
       make_paper<lags, kOwn>},
      {"paper-road", "the paper, road measured, lag 0", true, make_paper<one_lag, kRoad>},
      {"paper-road-lags", "the paper, road measured, lags of 0, 4 and 10 ms", true,
       make_paper<road_lags, kRoad>},
      {"windowed-road", "road measured, the relation's exact form for a finite record", true,
       make_paper<windowed, kRoad>},
  };
}

std::vector<EstimatorKind> own_past_kinds() {
  return {
      {"own-past", "instruments the wheel's acceleration 10, 20 and 40 ms ago and its angle: no road in them",
       false, make_paper<past, kPast>},
      {"own-past-windowed", "own-past in the exact form for a finite record", false,
       make_paper<windowed_past, kPast>},
  };
}

}  // namespace roadbalance
