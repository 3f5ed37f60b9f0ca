#include "tools/study/fig3.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/study/cramer_rao.hpp"
#include "tools/study/estimator_trial.hpp"
#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
constexpr int kFig3Wheel = 0;
constexpr double kStart = 1.1;  ///< a search for the tyre stiffness begins this far from the truth

const std::complex<double> kFig3Unbalance = std::polar(0.030 * 0.19, 40.0 * std::numbers::pi / 180.0);

IdealDrive drive_of(const Json& settings, const VehicleConfig& vehicle) {
  IdealDrive drive{.scenario = plain_scenario(vehicle),
                   .speeds_m_s = speeds_between(110.0, 130.0, 4),
                   .samples = 0,
                   .road_measured = true};
  for (const Json& samples : settings["samples"])
    drive.samples = std::max(drive.samples, samples.get<Eigen::Index>());
  drive.scenario.road.roughness_m3 = settings["road_gd_m3"].get<double>();
  drive.scenario.road.rear_coherence2 = settings["rear_coherence2"].get<double>();
  drive.scenario.wheel[kFig3Wheel].unbalance_kg_m = kFig3Unbalance;
  return drive;
}

Question question_of(const CarTruth& truth, const VehicleConfig& vehicle) {
  Question question{geometry_of(vehicle.model), truth.parameters, {}};
  question.known(kTyre + kFig3Wheel) *= kStart;
  for (const int asked : {kEstimatedTyre + kFig3Wheel, kEstimatedUnbalance + 2 * kFig3Wheel,
                          kEstimatedUnbalance + 2 * kFig3Wheel + 1})
    question.asked.set(static_cast<std::size_t>(asked));
  return question;
}

std::string key_of(const Json& samples) {
  return std::to_string(samples.get<Eigen::Index>());
}

Json run_fig3(const StudyRun& run) {
  const VehicleConfig vehicle = demo_vehicle();
  const IdealDrive drive = drive_of(run.settings, vehicle);
  const CarTruth truth = truth_of(drive, run.seed, vehicle);
  const Question question = question_of(truth, vehicle);
  const std::vector<Stretch> with_road = drive_ideally(drive, run.seed, vehicle);
  Json result{{"seed", run.seed}};
  for (const Json& samples : run.settings["samples"]) {
    const std::vector<Stretch> measured = shortened(with_road, samples.get<Eigen::Index>());
    std::vector<Stretch> blind = measured;
    for (Stretch& stretch : blind) stretch.road_m.resize(kWheels, 0);
    for (const EstimatorKind& kind : chosen_estimators(run.settings["estimators"].get<std::string>()))
      result[key_of(samples)][kind.name] =
          errors_of(ask(kind, question, truth, kind.road_measured ? measured : blind), truth, kFig3Wheel);
  }
  return result;
}

/// Errors of all runs with so many samples.
std::vector<double> errors(const std::vector<Json>& runs, const std::string& samples, const std::string& name,
                           const char* key) {
  std::vector<double> result;
  for (const Json& run : runs) {
    const Json& value = run[samples][name][key];
    result.push_back(value.is_number() ? value.get<double>() : std::nan(""));
  }
  return result;
}

/// @param random_part  what the road's shape of spectrum tells, too
WheelBound bound_for(const Json& settings, double samples, double rear_coherence2, bool random_part = true) {
  const VehicleConfig vehicle = demo_vehicle();
  const IdealDrive drive = drive_of(settings, vehicle);
  BoundQuestion question{.geometry = geometry_of(vehicle.model), .parameters = nominal_parameters(vehicle)};
  question.unbalance_kg_m[kFig3Wheel] = kFig3Unbalance;
  question.speeds_m_s = drive.speeds_m_s;
  question.seconds = samples / drive.rate_hz;
  question.road.roughness_m3 = drive.scenario.road.roughness_m3;
  question.road.left_right_correlation = drive.scenario.road.left_right_correlation;
  question.road.rear_own_correlation = drive.scenario.road.left_right_correlation;
  question.road.rear_coherence2 = rear_coherence2;
  question.asked = question_of({question.parameters, {}}, vehicle).asked;
  question.exponent_free = true;
  question.random_part = random_part;
  return wheel_bound(cramer_rao(question), question, kFig3Wheel);
}

Json bound_row(const std::string& name, const Json& samples, const WheelBound& bound) {
  return {{"estimator", name},
          {"samples", samples},
          {"ct sd %", bound.tyre_percent},
          {"mass sd %", bound.mass_percent},
          {"angle sd deg", bound.angle_deg}};
}

Json row_of(const std::vector<Json>& runs, const std::string& name, const Json& samples) {
  Json row{{"estimator", name},
           {"samples", samples},
           {"answers", answers_among(errors(runs, key_of(samples), name, "mass_percent"))}};
  struct Column {
    const char *key, *what, *unit;
  };
  for (const auto& [key, what, unit] :
       {Column{"tyre_percent", "ct", " %"}, {"mass_percent", "mass", " %"}, {"angle_deg", "angle", " deg"}}) {
    const ErrorSizes sizes = sizes_of(errors(runs, key_of(samples), name, key));
    row[std::string(what) + " median" + unit] = number_or_null(sizes.median);
    row[std::string(what) + " p95" + unit] = number_or_null(sizes.p95);
    row[std::string(what) + " sd" + unit] = number_or_null(sizes.deviation);
  }
  return row;
}

/// Rows by estimator and number of samples; null: there is none.
double value_of(const Json& rows, const std::string& name, int samples, const std::string& column) {
  for (const Json& row : rows)
    if (row["estimator"] == name && row["samples"] == samples && row.contains(column))
      return row[column].is_number() ? row[column].get<double>() : std::nan("");
  return std::nan("");
}

const std::string kHarmonicBound = "bound, 0, harmonic part";
constexpr double kMedianOfDeviation = 0.6745;  ///< median of a normal error's size over its deviation

struct Quantity {
  const char *name, *unit, *median, *deviation;
};
constexpr Quantity kQuantities[] = {{"stiffness", "%", "ct median %", "ct sd %"},
                                    {"mass", "%", "mass median %", "mass sd %"},
                                    {"angle", "deg", "angle median deg", "angle sd deg"}};

/// What the paper reads off its Fig. 3; road, size of unbalance and lags are not given there.
std::string claim_of(const Quantity& quantity, int samples) {
  if (std::string(quantity.name) == "stiffness")
    return samples >= 5000 ? "enough samples" : "too few samples";
  return samples >= 20000 ? "< 10 " + std::string(quantity.unit) : "too few samples";
}

/// The ways that eliminate the road by lambda: nothing but the harmonic part is left to them.
constexpr const char* kByLambda[] = {"paper", "paper-lags", "paper-own"};
constexpr double kMostOfBound = 1.3;
/// Where the bound is wider the errors are no more those of a linear problem, which the bound is of.
constexpr double kLinearBound_percent = 40.0;

/// The paper's claim, ours and the bound of the harmonic part, side by side.
Json claims_of(const Json& rows, const Json& samples) {
  Json table = Json::array();
  for (const char* name : kByLambda)
    for (const Json& n : samples)
      for (const Quantity& quantity : kQuantities) {
        const double ours = value_of(rows, name, n.get<int>(), quantity.median);
        if (!std::isfinite(ours)) continue;  // --set estimators=...
        const double bound =
            kMedianOfDeviation * value_of(rows, kHarmonicBound, n.get<int>(), quantity.deviation);
        table.push_back({{"estimator", name},
                         {"samples", n},
                         {"of", std::string(quantity.name) + ", " + quantity.unit},
                         {"the paper", claim_of(quantity, n.get<int>())},
                         {"ours, median", ours},
                         {"harmonic bound, median", bound},
                         {"ours / bound", number_or_null(ours / bound)}});
      }
  return table;
}

Json acceptance_of(const Json& rows) {
  Json lines = Json::array();
  const auto holds = [&](int samples) {
    return std::isfinite(value_of(rows, "bound, 0", samples, "ct sd %"));
  };
  const auto judge = [&](const std::string& text, const std::string& name, int samples, const char* column,
                         double unit, double least, double most) {
    const bool ran =
        std::any_of(rows.begin(), rows.end(), [&](const Json& row) { return row["estimator"] == name; });
    if (!ran) return;  // --set estimators=...
    const double answers = value_of(rows, name, samples, "answers");
    lines.push_back(acceptance_line(text, value_of(rows, name, samples, column) / unit, least, most,
                                    std::isfinite(answers) ? static_cast<std::size_t>(answers) : 0));
  };
  const auto of = [](const std::string& name, int samples, const std::string& rest) {
    return name + ", " + std::to_string(samples) + " samples, " + rest;
  };
  for (const char* name : kByLambda)
    for (const int samples : {5000, 20000, 100000})
      if (value_of(rows, kHarmonicBound, samples, "ct sd %") < kLinearBound_percent)
        for (const Quantity& quantity : kQuantities)
          judge(of(name, samples, std::string(quantity.median) + ", of the harmonic part's bound"), name,
                samples, quantity.median,
                kMedianOfDeviation * value_of(rows, kHarmonicBound, samples, quantity.deviation), 0.0,
                kMostOfBound);
  for (const int samples : {20000, 100000})
    for (const char* column : {"mass sd %", "angle sd deg"})
      if (holds(samples))
        judge(of("whittle", samples, std::string(column) + ", of the bound without cancellation"), "whittle",
              samples, column, value_of(rows, "bound, 0", samples, column), 0.0, 1.15);
  for (const auto& [samples, most] : {std::pair{20000, 1.2}, {5000, 2.0}})
    if (holds(samples))
      judge(of("whittle", samples, "ct median %"), "whittle", samples, "ct median %", 1.0, 0.0, most);
  for (const auto& [column, most] : {std::pair{"mass median %", 0.15}, {"angle median deg", 0.05}})
    if (holds(20000))
      judge(of("road measured", 20000, column), "windowed-road", 20000, column, 1.0, 0.0, most);
  return lines;
}

Figure figure_of(const Json& rows, const Json& samples, const std::vector<std::string>& names,
                 const std::string& file, const std::string& what, const std::string& median,
                 const std::string& sd) {
  Figure figure{file,
                what + ": median error against samples at each speed",
                {"samples at each speed", true},
                {median, true},
                {}};
  for (const std::string& name : names) {
    const bool bound = name.starts_with("bound");
    Series series{bound ? name + " (x 0.67)" : name, {}, {}, bound, !bound};
    for (const Json& n : samples) {
      series.x.push_back(n.get<double>());
      series.y.push_back(bound ? kMedianOfDeviation * value_of(rows, name, n.get<int>(), sd)
                               : value_of(rows, name, n.get<int>(), median));
    }
    figure.series.push_back(series);
  }
  return figure;
}

StudyResult summarise_fig3(const Json& settings, const std::vector<Json>& runs) {
  Json rows = Json::array();
  std::vector<std::string> names{"bound, 0", kHarmonicBound};
  const double coherence2 = settings["rear_coherence2"].get<double>();
  if (coherence2 > 0.0) names.push_back("bound, " + Json(coherence2).dump());
  for (const Json& samples : settings["samples"]) {
    rows.push_back(bound_row("bound, 0", samples, bound_for(settings, samples.get<double>(), 0.0)));
    rows.push_back(
        bound_row(kHarmonicBound, samples, bound_for(settings, samples.get<double>(), 0.0, false)));
    if (coherence2 > 0.0)
      rows.push_back(bound_row(names[2], samples, bound_for(settings, samples.get<double>(), coherence2)));
  }
  for (const EstimatorKind& kind : chosen_estimators(settings["estimators"].get<std::string>())) {
    names.push_back(kind.name);
    for (const Json& samples : settings["samples"]) rows.push_back(row_of(runs, kind.name, samples));
  }
  const Json acceptance = acceptance_of(rows);
  const Json& samples = settings["samples"];
  return {{{"runs", runs.size()},
           {"settings", settings},
           {"tables",
            {{{"title",
               "Errors of the front left wheel; bound, c: Cramer-Rao with rear coherence^2 c, exponent free"},
              {"rows", rows}},
             {{"title",
               "The paper's Fig. 3 as it reads it, ours, and what the harmonic part alone can tell "
               "(Cramer-Rao, rear coherence^2 0): medians, as eliminating the road by lambda leaves them"},
              {"rows", claims_of(rows, settings["samples"])}}}},
           {"acceptance", acceptance},
           {"accepted", all_met(acceptance)}},
          {figure_of(rows, samples, names, "fig3-ct", "Tyre stiffness", "ct median %", "ct sd %"),
           figure_of(rows, samples, names, "fig3-mass", "Unbalanced mass", "mass median %", "mass sd %"),
           figure_of(rows, samples, names, "fig3-angle", "Angle", "angle median deg", "angle sd deg")}};
}

}  // namespace

Study fig3_study() {
  return {.name = "fig3",
          .line = "the paper's Fig. 3: errors of stiffness, mass and angle against samples, every estimator",
          .options = {"--runs", "--seed", "--state", "--jobs", "--set", "--svg", "--markdown"},
          .settings = {{"samples", {1000, 5000, 20000, 100000}},
                       {"road_gd_m3", 16e-6},
                       {"rear_coherence2", 0.95},
                       {"estimators", ""}},
          .runs = 40,
          .run = run_fig3,
          .summarise = summarise_fig3};
}

}  // namespace roadbalance
