#include "host/analysis/identify/estimators/paper.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "host/analysis/identify/estimators/unknown_road.hpp"

namespace roadbalance {
namespace {

template <auto Options>
std::unique_ptr<Estimator> make(const Question& question) {
  return std::make_unique<RelationEstimator>(question, Options());
}

using Instruments = RelationInstruments;
using Road = RelationRoad;
const std::vector<double> kLags_s{0.0, 0.010, 0.020, 0.040};
const std::vector<double> kRoadLags_s{0.0, 0.004, 0.010};
const std::vector<double> kPast_s{0.010, 0.020, 0.040};

RelationOptions paper() {
  return {.instruments = Instruments::kAll, .road = Road::kUnknown};
}
RelationOptions paper_lags() {
  return {.instruments = Instruments::kAll, .road = Road::kUnknown, .filter = {.lags_s = kLags_s}};
}
RelationOptions paper_own() {
  return {.instruments = Instruments::kOwn, .road = Road::kUnknown, .filter = {.lags_s = kLags_s}};
}
RelationOptions paper_road() {
  return {.instruments = Instruments::kAll, .road = Road::kMeasured};
}
RelationOptions paper_road_lags() {
  return {.instruments = Instruments::kAll, .road = Road::kMeasured, .filter = {.lags_s = kRoadLags_s}};
}
RelationOptions windowed_road() {
  return {.instruments = Instruments::kAll, .road = Road::kMeasured, .filter = {.windowed = true}};
}
RelationOptions own_past() {
  return {.instruments = Instruments::kOwn, .road = Road::kNone, .filter = {.lags_s = kPast_s}};
}
RelationOptions own_past_windowed() {
  return {
      .instruments = Instruments::kOwn, .road = Road::kNone, .filter = {.lags_s = kPast_s, .windowed = true}};
}

}  // namespace

RelationEstimator::RelationEstimator(Question question, RelationOptions options)
    : question_(std::move(question)), options_(std::move(options)), filter_(options_.filter) {}

void RelationEstimator::add(const Stretch& stretch) {
  if (options_.road == Road::kMeasured && stretch.road_m.cols() == 0) return;
  filter_.parts(stretch,
                [this](double speed_m_s, const RelationCovariances& part) { sums_.add(speed_m_s, part); });
}

EstimatorAnswer RelationEstimator::solve() const {
  EstimatorAnswer answer = options_.road == Road::kUnknown ? solve_with_unknown_road() : solve_directly();
  if (options_.road == Road::kUnknown)
    answer.diagnostics.emplace_back(
        "the road is eliminated by how its covariances grow with the speed, and with it what it tells of the "
        "tyres: stiffness and unbalance rest on the unbalance's own vibration");
  if (options_.instruments == Instruments::kAngles)
    answer.diagnostics.emplace_back(
        "± is the scatter alone: the road's share in the equations pulls stiffness and unbalance off beyond "
        "it, the more the shorter the drive");
  if (options_.road == Road::kMeasured && !question_.known.segment<kWheels>(kTyreDamper).isZero(0.0))
    answer.diagnostics.emplace_back(
        "the damping of the tyres in vehicle.toml (tyre_damper_n_s_m) acts on the road's rate of change, "
        "too, which these equations leave out: stiffness and unbalance are off beyond ±");
  if (answer.x.allFinite()) return answer;
  const std::size_t speeds = sums_.speeds();
  if (speeds == 0)
    answer.diagnostics.emplace_back(
        options_.road == Road::kMeasured ? "no steady driving over a measured road" : "no steady driving");
  else if (options_.road == Road::kUnknown && speeds < 2)
    answer.diagnostics.emplace_back(
        "the road is not measured and only speeds tell the stiffness from the unbalance: drive at two speeds "
        "or more");
  else
    answer.diagnostics.emplace_back(
        "the drive does not tell all that was asked; a wheel without angle has no unbalance");
  return answer;
}

EstimatorAnswer RelationEstimator::solve_directly() const {
  return sums_.solve(question_, [this](const BySpeed<RelationCovariances>& sums) {
    return solve_relation(sums, question_, options_);
  });
}

EstimatorAnswer RelationEstimator::solve_with_unknown_road() const {
  const BySpeed<RelationCovariances> all = sums_.all();
  const auto road = UnknownRoad::fit(all, question_, options_);
  if (!road) return judged(question_, std::nullopt, std::nullopt);
  // Weights and lambda of the whole serve every group: fitted anew they differ by what the groups' own
  // scatter makes of them, which is of second order.
  const auto solve = [&](const BySpeed<RelationCovariances>& sums) { return road->solve(sums); };
  return judged(question_, solve(all), sums_.covariance(solve));
}

std::vector<EstimatorKind> paper_kinds() {
  return {
      {"paper", "the paper: all covariances at lag 0, those with the road unknown", false, make<paper>},
      {"paper-lags", "the paper with lags of 0, 10, 20 and 40 ms", false, make<paper_lags>},
      {"paper-own", "the same, instruments the wheel's own acceleration and angle", false, make<paper_own>},
      {"paper-road", "the paper, road measured, lag 0", true, make<paper_road>},
      {"paper-road-lags", "the paper, road measured, lags of 0, 4 and 10 ms", true, make<paper_road_lags>},
      {"windowed-road", "road measured, the relation's exact form for a finite record", true,
       make<windowed_road>},
  };
}

std::vector<EstimatorKind> own_past_kinds() {
  return {
      {"own-past", "instruments the wheel's acceleration 10, 20 and 40 ms ago and its angle: no road in them",
       false, make<own_past>},
      {"own-past-windowed", "own-past in the exact form for a finite record", false, make<own_past_windowed>},
  };
}

}  // namespace roadbalance
