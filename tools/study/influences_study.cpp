#include <cstdio>
#include <numbers>

#include "tools/study/ideal_studies.hpp"
#include "tools/study/trial_cases.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// One influence: its cases, each with the value that is varied.
struct Influence {
  std::string name, axis;
  std::vector<std::pair<double, TrialCase>> cases;
};

std::string label(const std::string& what, double value, const char* unit) {
  char text[80];
  std::snprintf(text, sizeof text, "%s %g %s", what.c_str(), value, unit);
  return text;
}

/// 30 g on the front left wheel, its tyre and unbalance asked for; the other wheels balanced.
TrialCase one_wheel(const std::string& name, const Json& settings) {
  TrialCase one = four_wheels(name, settings["samples"].get<Eigen::Index>(), 0.95);
  for (std::size_t w = 1; w < kWheels; ++w) one.drive.scenario.wheel[w] = {};
  one.question.asked.reset();
  one.question.asked.set(kEstimatedUnbalance).set(kEstimatedUnbalance + 1);
  one.wheels = {0};
  ask_for_tyres(one);
  one.estimators = registered({"own-past", "whittle", "cancellation"});
  return one;
}

Influence speed(const Json& settings) {
  Influence result{"speed", "middle speed, km/h", {}};
  for (const double speed : {70.0, 90.0, 110.0, 130.0, 150.0}) {
    TrialCase one = one_wheel(label("speed", speed, "km/h"), settings);
    one.drive.speeds_m_s = speeds_between(speed - 10.0, speed + 10.0, 4);
    result.cases.emplace_back(speed, one);
  }
  return result;
}

Influence size(const Json& settings) {
  Influence result{"size", "unbalance, g", {}};
  for (const double grams : {5.0, 10.0, 20.0, 30.0, 60.0, 120.0}) {
    TrialCase one = one_wheel(label("size", grams, "g"), settings);
    one.drive.scenario.wheel[0].unbalance_kg_m *= grams / 30.0;
    result.cases.emplace_back(grams, one);
  }
  return result;
}

/// Effect of the front right wheel's unbalance, estimated as well, on the front left's estimate.
Influence other_side(const Json& settings) {
  Influence result{"other-side", "unbalance of the front right wheel, g", {}};
  for (const double grams : {0.0, 30.0, 60.0, 120.0}) {
    TrialCase one = one_wheel(label("other side", grams, "g"), settings);
    one.drive.scenario.wheel[1].unbalance_kg_m = std::polar(1e-3 * grams * 0.19, -1.7);
    one.question.asked.set(kEstimatedUnbalance + 2).set(kEstimatedUnbalance + 3);
    result.cases.emplace_back(grams, one);
  }
  return result;
}

/// Wheels that turn nearly in step: all four unbalanced, radii spread by a little.
Influence difference(const Json& settings) {
  Influence result{"difference", "spread of the rolling radii, %", {}};
  for (const double percent : {0.0, 0.01, 0.03, 0.1, 0.3, 1.0}) {
    TrialCase one = one_wheel(label("radii +-", percent, "%"), settings);
    for (std::size_t w = 1; w < kWheels; ++w)
      one.drive.scenario.wheel[w].unbalance_kg_m = std::polar(0.020 * 0.19, static_cast<double>(w));
    for (std::size_t a = kEstimatedUnbalance; a < kUnknowns; ++a) one.question.asked.set(a);
    one.drive.scenario.rolling_radius_spread = percent / 100.0;
    result.cases.emplace_back(percent, one);
  }
  return result;
}

/// A stabiliser that couples the front wheels, both unbalanced.
Influence stabiliser(const Json& settings) {
  Influence result{"stabiliser", "front stabiliser, kN/m", {}};
  for (const double stiffness : {0.0, 12.0, 24.0, 48.0, 96.0}) {
    TrialCase one = one_wheel(label("stabiliser", stiffness, "kN/m"), settings);
    one.vehicle.model.axle[0].stabiliser_n_m = 1e3 * stiffness;
    one.question.known(kStabiliser) = 1e3 * stiffness;
    one.drive.scenario.wheel[1].unbalance_kg_m = std::polar(0.030 * 0.19, -1.7);
    one.question.asked.set(kEstimatedUnbalance + 2).set(kEstimatedUnbalance + 3);
    result.cases.emplace_back(stiffness, one);
  }
  return result;
}

std::vector<Influence> influences(const Json& settings) {
  return {speed(settings), size(settings), other_side(settings), difference(settings), stabiliser(settings)};
}

std::vector<TrialCase> all_cases(const Json& settings) {
  std::vector<TrialCase> cases;
  for (Influence& influence : influences(settings))
    for (auto& [value, one] : influence.cases) cases.push_back(std::move(one));
  return cases;
}

Json run_influences(const StudyRun& run) {
  return run_cases(all_cases(run.settings), run.seed);
}

StudyResult summarise_influences(const Json& settings, const std::vector<Json>& runs) {
  const Json rows = case_rows(all_cases(settings), runs);
  std::vector<Figure> figures;
  for (const Influence& influence : influences(settings)) {
    Figure figure{"influence-" + influence.name,
                  "Error of the unbalance",
                  {influence.axis},
                  {"mass median %", true},
                  {}};
    for (const EstimatorKind& kind : influence.cases.front().second.estimators) {
      Series series{kind.name, {}, {}};
      for (const auto& [value, one] : influence.cases) {
        series.x.push_back(value);
        series.y.push_back(value_in(rows, one.name, kind.name, "mass median %"));
      }
      figure.series.push_back(series);
    }
    figures.push_back(figure);
  }
  return {summary_of(settings, runs.size(),
                     "Front left wheel: 30 g, four speeds 110 .. 130 km/h unless the case says otherwise",
                     rows, {}),
          figures};
}

}  // namespace

Study influences_study() {
  return {.name = "influences",
          .line = "speed, size of the unbalance, the other side, frequency difference, stabiliser",
          .options = kIdealOptions,
          .settings = {{"samples", 20000}},
          .runs = 20,
          .run = run_influences,
          .summarise = summarise_influences};
}

}  // namespace roadbalance
