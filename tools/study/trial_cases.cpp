#include "tools/study/trial_cases.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/text/format.hpp"
#include "host/analysis/identify/whittle_moments.hpp"
#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

std::vector<double> errors_of_wheel(const std::vector<Json>& runs, const TrialCase& one,
                                    const std::string& estimator, std::size_t wheel, const char* key) {
  std::vector<double> result;
  for (const Json& run : runs) {
    const Json& errors = run[one.name][estimator][wheel];
    const bool told = errors.contains(key) && errors[key].is_number();
    result.push_back(told ? errors[key].get<double>() : std::nan(""));
  }
  return result;
}

double variance_of(const std::vector<Json>& runs, const TrialCase& one, const std::string& estimator,
                   std::size_t wheel, const char* key) {
  const double deviation = standard_deviation(errors_of_wheel(runs, one, estimator, wheel, key));
  return deviation * deviation;
}

BoundQuestion bound_question(const TrialCase& one) {
  BoundQuestion bound{.geometry = one.question.geometry,
                      .parameters = nominal_parameters(one.vehicle),
                      .speeds_m_s = one.drive.speeds_m_s,
                      .seconds = static_cast<double>(one.drive.samples) / one.drive.rate_hz};
  const sim::RoadScenario& road = one.drive.scenario.road;
  bound.road = {.roughness_m3 = road.roughness_m3,
                .left_right_correlation = road.left_right_correlation,
                .rear_coherence2 = road.rear_coherence2,
                .rear_own_correlation = road.left_right_correlation};
  for (std::size_t w = 0; w < kWheels; ++w)
    bound.unbalance_kg_m[w] = one.drive.scenario.wheel[w].unbalance_kg_m;
  // No two wheels turn in step: the sheet's bound of each is that of its own order.
  bound.asked = one.question.asked;
  bound.exponent_free = true;
  return bound;
}

/// Mean square of the tyres' bounds, %^2, and the estimator's efficiency against them.
std::pair<double, double> against_tyre_bound(const BoundQuestion& question, const UnknownMatrix& bound,
                                             const TrialCase& one, const std::string& estimator,
                                             const std::vector<Json>& runs) {
  const auto n = static_cast<double>(one.wheels.size());
  double square = 0.0, efficiency = 0.0;
  for (std::size_t i = 0; i < one.wheels.size(); ++i) {
    const double least = wheel_bound(bound, question, one.wheels[i]).tyre_percent;
    square += least * least / n;
    efficiency += least * least / n / variance_of(runs, one, estimator, i, "tyre_percent");
  }
  return {square, efficiency};
}

/// Adds the bound, and how near the estimator comes to it.
void add_bound(Json& row, const TrialCase& one, const std::string& estimator, const std::vector<Json>& runs) {
  const BoundQuestion question = bound_question(one);
  const UnknownMatrix bound = cramer_rao(question);
  const auto n = static_cast<double>(one.wheels.size());
  double mass = 0.0, efficiency_u = 0.0;
  for (std::size_t i = 0; i < one.wheels.size(); ++i) {
    const WheelBound wheel = wheel_bound(bound, question, one.wheels[i]);
    const double size = std::abs(question.unbalance_kg_m[static_cast<std::size_t>(one.wheels[i])]);
    const double u = (std::pow(wheel.re_kg_m, 2) + std::pow(wheel.im_kg_m, 2)) * 1e4 / (size * size);
    mass += wheel.mass_percent * wheel.mass_percent / n;
    efficiency_u += u / n /
                    (variance_of(runs, one, estimator, i, "re_percent") +
                     variance_of(runs, one, estimator, i, "im_percent"));
  }
  row["mass bound %"] = number_or_null(std::sqrt(mass));
  row["efficiency U"] = number_or_null(efficiency_u);
  if (!one.question.asks_for_tyre(one.wheels.front())) return;
  const auto [square, efficiency] = against_tyre_bound(question, bound, one, estimator, runs);
  row["ct bound %"] = number_or_null(std::sqrt(square));
  row["efficiency ct"] = number_or_null(efficiency);
  BoundQuestion in_band = question;
  in_band.low_hz = kWhittleFrom_hz, in_band.high_hz = kWhittleTo_hz;
  const auto [band_square, band_efficiency] =
      against_tyre_bound(in_band, cramer_rao(in_band), one, estimator, runs);
  row["ct bound % of " + whittle_band()] = number_or_null(std::sqrt(band_square));
  row["efficiency ct of " + whittle_band()] = number_or_null(band_efficiency);
}

void add_sizes(Json& row, const std::vector<double>& errors, const std::string& what,
               const std::string& unit) {
  const ErrorSizes sizes = sizes_of(errors);
  row[what + " median " + unit] = number_or_null(sizes.median);
  row[what + " p95 " + unit] = number_or_null(sizes.p95);
  row[what + " sd " + unit] = number_or_null(sizes.deviation);
}

}  // namespace

std::string whittle_band() {
  return format("%g-%g Hz", kWhittleFrom_hz, kWhittleTo_hz);
}

TrialCase four_wheels(const std::string& name, Eigen::Index samples, double rear_coherence2) {
  const VehicleConfig vehicle = demo_vehicle();
  TrialCase one{name,
                vehicle,
                {.scenario = plain_scenario(vehicle),
                 .speeds_m_s = speeds_between(110.0, 130.0, 4),
                 .samples = samples},
                {geometry_of(vehicle.model), nominal_parameters(vehicle), {}},
                {},
                {0, 1, 2, 3}};
  one.drive.scenario.road.rear_coherence2 = rear_coherence2;
  constexpr double kGrams[kWheels] = {30.0, 20.0, 25.0, 15.0},
                   kAngles_deg[kWheels] = {40.0, -97.0, 160.0, 75.0};
  for (std::size_t w = 0; w < kWheels; ++w) {
    one.drive.scenario.wheel[w].unbalance_kg_m =
        std::polar(1e-3 * kGrams[w] * 0.19, kAngles_deg[w] * std::numbers::pi / 180.0);
    one.question.asked.set(kEstimatedUnbalance + 2 * w).set(kEstimatedUnbalance + 2 * w + 1);
  }
  return one;
}

void ask_for_tyres(TrialCase& one) {
  for (const int wheel : one.wheels) {
    one.question.asked.set(static_cast<std::size_t>(kEstimatedTyre + wheel));
    one.question.known(kTyre + wheel) *= 1.1;
  }
}

std::vector<EstimatorKind> registered(const std::vector<std::string>& names) {
  std::vector<EstimatorKind> result;
  for (const std::string& name : names)
    for (const EstimatorKind& kind : estimators())
      if (kind.name == name) result.push_back(kind);
  return result;
}

Json run_cases(const std::vector<TrialCase>& cases, std::uint64_t seed) {
  Json result{{"seed", seed}};
  for (const TrialCase& one : cases) {
    std::vector<Stretch> stretches = drive_ideally(one.drive, seed, one.vehicle);
    if (one.spoil)
      for (Stretch& stretch : stretches) one.spoil(stretch, seed);
    const CarTruth truth = truth_of(one.drive, seed, one.vehicle);
    for (const EstimatorKind& kind : one.estimators) {
      const EstimatorAnswer answer = ask(kind, one.question, truth, stretches);
      Json& errors = result[one.name][kind.name] = Json::array();
      for (const int wheel : one.wheels) errors.push_back(errors_of(answer, truth, wheel));
    }
  }
  return result;
}

std::vector<double> errors_in(const std::vector<Json>& runs, const TrialCase& one,
                              const std::string& estimator, const char* key) {
  std::vector<double> result;
  for (std::size_t i = 0; i < one.wheels.size(); ++i) {
    const std::vector<double> wheel = errors_of_wheel(runs, one, estimator, i, key);
    result.insert(result.end(), wheel.begin(), wheel.end());
  }
  return result;
}

double unbalance_deviation(const std::vector<Json>& runs, const TrialCase& one,
                           const std::string& estimator) {
  double variance = 0.0;
  for (std::size_t i = 0; i < one.wheels.size(); ++i)
    for (const char* key : {"re_percent", "im_percent"})
      variance += variance_of(runs, one, estimator, i, key);
  return std::sqrt(0.5 * variance / static_cast<double>(one.wheels.size()));
}

Json case_rows(const std::vector<TrialCase>& cases, const std::vector<Json>& runs) {
  Json rows = Json::array();
  for (const TrialCase& one : cases)
    for (const EstimatorKind& kind : one.estimators) {
      const auto errors = [&](const char* key) { return errors_in(runs, one, kind.name, key); };
      Json row{
          {"case", one.name}, {"estimator", kind.name}, {"answers", answers_among(errors("mass_percent"))}};
      if (one.question.asks_for_tyre(one.wheels.front())) add_sizes(row, errors("tyre_percent"), "ct", "%");
      add_sizes(row, errors("mass_percent"), "mass", "%");
      add_sizes(row, errors("angle_deg"), "angle", "deg");
      add_bound(row, one, kind.name, runs);
      rows.push_back(row);
    }
  return rows;
}

double value_in(const Json& rows, const std::string& name, const std::string& estimator,
                const std::string& column) {
  for (const Json& row : rows)
    if (row["case"] == name && row["estimator"] == estimator && row.contains(column) &&
        row[column].is_number())
      return row[column].get<double>();
  return std::nan("");
}

std::size_t answers_in(const Json& rows, const std::string& name, const std::string& estimator) {
  const double answers = value_in(rows, name, estimator, "answers");
  return std::isfinite(answers) ? static_cast<std::size_t>(answers) : 0;
}

Json summary_of(const Json& settings, std::size_t runs, const std::string& title, const Json& rows,
                const Json& acceptance) {
  Json summary{{"runs", runs}, {"settings", settings}, {"tables", {{{"title", title}, {"rows", rows}}}}};
  if (!acceptance.is_null()) {
    summary["acceptance"] = acceptance;
    summary["accepted"] = all_met(acceptance);
  }
  return summary;
}

}  // namespace roadbalance
