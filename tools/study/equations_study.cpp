#include <array>
#include <map>
#include <memory>
#include <string>

#include "host/analysis/identify/estimators/paper.hpp"
#include "tools/study/ideal_studies.hpp"
#include "tools/study/statistics.hpp"
#include "tools/study/trial_cases.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSpeeds = 4;
constexpr double kCutoff_hz = 30.0;

/// A variant of the relation's least squares: lags of 10, 20, 30 ... ms, or with an unknown road from 0 on.
struct Variant {
  EstimatorKind kind;
  int order, lags;
  bool road_unknown;
};

template <int kOrder, int kLags, bool kRoadUnknown>
std::unique_ptr<Estimator> make(const Question& question) {
  RelationOptions options{.instruments = kRoadUnknown ? RelationInstruments::kAll : RelationInstruments::kOwn,
                          .road = kRoadUnknown ? RelationRoad::kUnknown : RelationRoad::kNone,
                          .filter = {.order = kOrder, .cutoff_hz = kCutoff_hz, .lags_s = {}}};
  for (int i = 0; i < kLags; ++i) options.filter.lags_s.push_back(0.010 * (kRoadUnknown ? i : i + 1));
  return std::make_unique<RelationEstimator>(question, options);
}

template <int kOrder, int kLags, bool kRoadUnknown>
Variant variant() {
  const std::string name = "order " + std::to_string(kOrder) + ", " + std::to_string(kLags) +
                           (kLags == 1 ? " lag" : " lags") + (kRoadUnknown ? ", road unknown" : ", own past");
  return {{name, "", false, make<kOrder, kLags, kRoadUnknown>}, kOrder, kLags, kRoadUnknown};
}

std::vector<Variant> variants() {
  return {variant<3, 1, true>(),  variant<4, 1, true>(),  variant<5, 1, true>(),  variant<6, 1, true>(),
          variant<8, 1, true>(),  variant<3, 4, true>(),  variant<5, 4, true>(),  variant<8, 4, true>(),
          variant<3, 1, false>(), variant<4, 1, false>(), variant<5, 1, false>(), variant<6, 1, false>(),
          variant<8, 1, false>(), variant<3, 4, false>(), variant<5, 4, false>(), variant<8, 4, false>()};
}

/// 30 g on the front left wheel, whose tyre and unbalance are asked for.
std::vector<TrialCase> equations_cases(const Json& settings) {
  TrialCase one = four_wheels("front left", settings["samples"].get<Eigen::Index>(), 0.95);
  for (std::size_t w = 1; w < kWheels; ++w) one.drive.scenario.wheel[w] = {};
  one.wheels = {0};
  one.question.asked.reset();
  one.question.asked.set(kEstimatedUnbalance).set(kEstimatedUnbalance + 1);
  ask_for_tyres(one);
  for (const Variant& v : variants()) one.estimators.push_back(v.kind);
  return {one};
}

Json run_equations(const StudyRun& run) {
  return run_cases(equations_cases(run.settings), run.seed);
}

StudyResult summarise_equations(const Json& settings, const std::vector<Json>& runs) {
  const auto cases = equations_cases(settings);
  const Json sizes = case_rows(cases, runs);
  Json rows = Json::array();
  Figure figure{"equations",
                "Median error of the mass against the number of equations (scaled)",
                {"equations of the wheel's row", true},
                {"mass median %", true},
                {{"road unknown", {}, {}}, {"own past", {}, {}}}};
  std::array<std::multimap<int, double>, 2> points;  // from few equations to many
  for (const Variant& v : variants()) {
    // Signals: with an unknown road seven accelerations and the wheel's angle (cos, sin); else its own three.
    const int instruments = (v.order - 2) * (v.road_unknown ? kCoordinates + 2 : 3);
    const int equations = kSpeeds * v.lags * instruments;
    const int unknowns = 3 + (v.road_unknown ? v.lags * instruments : 0);
    const auto value = [&](const char* column) { return value_in(sizes, "front left", v.kind.name, column); };
    rows.push_back({{"case", v.kind.name},
                    {"equations", equations},
                    {"unknowns", unknowns},
                    {"ct median %", number_or_null(value("ct median %"))},
                    {"mass median %", number_or_null(value("mass median %"))},
                    {"angle median deg", number_or_null(value("angle median deg"))},
                    {"ct sd %", number_or_null(value("ct sd %"))},
                    {"mass sd %", number_or_null(value("mass sd %"))}});
    points[v.road_unknown ? 0 : 1].emplace(equations, value("mass median %"));
  }
  for (std::size_t s = 0; s < points.size(); ++s)
    for (const auto& [equations, median] : points[s])
      figure.series[s].x.push_back(equations), figure.series[s].y.push_back(median);
  return {
      summary_of(settings, runs.size(),
                 "Front left wheel's row, filter 30 Hz, four speeds: equations, scaled by the rms of their "
                 "instruments (the estimator paper takes them unscaled), against unknowns",
                 rows, {}),
      {figure}};
}

}  // namespace

Study equations_study() {
  return {.name = "equations",
          .line = "order of the filter and number of equations against unknowns",
          .options = kIdealOptions,
          .settings = {{"samples", 20000}},
          .runs = 10,
          .run = run_equations,
          .summarise = summarise_equations};
}

}  // namespace roadbalance
