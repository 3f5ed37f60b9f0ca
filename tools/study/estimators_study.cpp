#include <limits>

#include "tools/study/ideal_studies.hpp"
#include "tools/study/statistics.hpp"
#include "tools/study/trial_cases.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

std::vector<TrialCase> estimators_cases(const Json& settings) {
  std::vector<TrialCase> cases;
  for (const double coherence2 : {0.0, 0.95}) {
    TrialCase one = four_wheels("coherence^2 " + Json(coherence2).dump(),
                                settings["samples"].get<Eigen::Index>(), coherence2);
    ask_for_tyres(one);
    for (const EstimatorKind& kind : chosen_estimators(settings["estimators"].get<std::string>()))
      if (!kind.road_measured) one.estimators.push_back(kind);
    cases.push_back(one);
  }
  return cases;
}

Json run_estimators(const StudyRun& run) {
  return run_cases(estimators_cases(run.settings), run.seed);
}

const std::string& band_column() {
  static const std::string column = "efficiency ct of " + whittle_band();
  return column;
}

Figure efficiencies(const Json& rows, const char* name, const std::string& column) {
  Figure figure{name,
                "Efficiency, " + column,
                {"coherence^2 of rear and front"},
                {"bound variance / measured variance"},
                {}};
  for (const Json& row : rows) {
    const std::string estimator = row["estimator"].get<std::string>();
    if (row["case"] != "coherence^2 0.0") continue;
    figure.series.push_back({estimator,
                             {0.0, 0.95},
                             {value_in(rows, "coherence^2 0.0", estimator, column),
                              value_in(rows, "coherence^2 0.95", estimator, column)}});
  }
  return figure;
}

StudyResult summarise_estimators(const Json& settings, const std::vector<Json>& runs) {
  const Json rows = case_rows(estimators_cases(settings), runs);
  Json lines = Json::array();
  const auto least = [&](const std::string& of, const char* estimator, const std::string& column,
                         double asked) {
    lines.push_back(acceptance_line(
        std::string(estimator) + ", " + of + ": " + column, value_in(rows, of, estimator, column), asked,
        std::numeric_limits<double>::infinity(), answers_in(rows, of, estimator)));
  };
  least("coherence^2 0.95", "cancellation", "efficiency U", 0.7);
  for (const char* of : {"coherence^2 0.0", "coherence^2 0.95"})
    for (const std::string& band : {band_column(), std::string("efficiency ct")})
      least(of, "whittle", band, 0.4);
  return {summary_of(settings, runs.size(),
                     "Four wheels unbalanced, tyres and unbalances asked for; bound with the exponent free",
                     rows, lines),
          {efficiencies(rows, "estimators-u", "efficiency U"),
           efficiencies(rows, "estimators-ct", band_column())}};
}

}  // namespace

Study estimators_study() {
  return {.name = "estimators",
          .line = "every estimator beside the Cramer-Rao bound, four wheels unbalanced",
          .options = kIdealOptions,
          .settings = {{"samples", 20000}, {"estimators", ""}},
          .runs = 30,
          .run = run_estimators,
          .summarise = summarise_estimators};
}

}  // namespace roadbalance
