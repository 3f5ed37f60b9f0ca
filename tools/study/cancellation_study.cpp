#include <cmath>

#include "tools/study/ideal_studies.hpp"
#include "tools/study/statistics.hpp"
#include "tools/study/trial_cases.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

const char* const kInStep = "0.95, wheels in step";
const char* const kTurned = "0.95, in step, angles drawn at each speed";

/// Share of the deviation that is left where wheels turn in step and rear follows front with coherence^2 c.
///
/// For front and rear line phasors U_f, U_r e^{j d_s} in sections s = 1 .. n of alike roads with the inverse
/// spectrum [1, -g; -g*, 1] / (S (1 - c)), |g|^2 = c, the information sums to n [1, -g r; -g* r*, 1] / (S (1
/// - c)) with r the mean of e^{j d_s}; its inverse has the variance S (1 - c) / (n (1 - c |r|^2)) instead of
/// S / n. One angle all through is r = 1 and gains nothing.  For four angles drawn evenly the mean of 1 / (1
/// - 0.95 |r|^2) is 1.54, so that sqrt(0.05 x 1.54) = 1 / 3.6 is left; the sheet's joint solution leaves 1 /
/// 3.4 of 25 runs.  Wheels that turn apart are left sqrt(0.05) = 1 / 4.5.
constexpr double kTurnedGain = 3.0;

std::vector<TrialCase> cancellation_cases(const Json& settings) {
  const auto samples = settings["samples"].get<Eigen::Index>();
  std::vector<TrialCase> cases;
  for (const auto& [name, coherence2] :
       {std::pair{"0", 0.0}, {"0.9", 0.9}, {"0.95", 0.95}, {"0.99", 0.99}, {kInStep, 0.95}, {kTurned, 0.95}})
    cases.push_back(four_wheels(name, samples, coherence2));
  for (const std::size_t in_step : {4, 5}) cases[in_step].drive.scenario.rolling_radius_spread = 0.0;
  cases[5].drive.angles_drawn_at_each_speed = true;
  for (TrialCase& one : cases) one.estimators = registered({"known-tyre", "harmonic", "cancellation"});
  return cases;
}

Json run_cancellation(const StudyRun& run) {
  return run_cases(cancellation_cases(run.settings), run.seed);
}

StudyResult summarise_cancellation(const Json& settings, const std::vector<Json>& runs) {
  const std::vector<TrialCase> cases = cancellation_cases(settings);
  const Json rows = case_rows(cases, runs);
  Json lines = Json::array();
  if (!cases.front().estimators.empty()) {
    const auto deviation = [&](std::size_t one, const char* estimator) {
      return registered({estimator}).empty() ? std::nan("")
                                             : unbalance_deviation(runs, cases[one], estimator);
    };
    const auto ratio = [&](std::size_t one) {
      return deviation(one, "cancellation") / deviation(one, "known-tyre");
    };
    const auto answers = [&](const char* name) { return answers_in(rows, name, "cancellation"); };
    const double none = std::numeric_limits<double>::infinity();
    lines = {
        acceptance_line("coherence^2 0.95: standard deviation without over with cancellation", 1.0 / ratio(2),
                        3.5, none, answers("0.95")),
        acceptance_line("coherence^2 0: standard deviation with over without cancellation", ratio(0), 0.0,
                        1.05, answers("0")),
        acceptance_line("coherence^2 0.95: efficiency with cancellation",
                        value_in(rows, "0.95", "cancellation", "efficiency U"), 0.7, none, answers("0.95")),
        // One wheel's unbalance given for another's in one answer of a hundred would make this 2.
        acceptance_line("wheels in step: standard deviation with over without cancellation", ratio(4), 0.0,
                        1.05, answers(kInStep)),
        acceptance_line("wheels in step at four relative angles: standard deviation without over with",
                        1.0 / ratio(5), kTurnedGain, none, answers(kTurned))};
  }
  Figure figure{"cancellation",
                "Standard deviation of an unbalance per axis",
                {"coherence^2 of rear and front"},
                {"% of it", true},
                {}};
  for (const EstimatorKind& kind : cases.front().estimators) {
    Series series{kind.name, {0.0, 0.9, 0.95, 0.99}, {}};
    for (std::size_t i = 0; i < 4; ++i) series.y.push_back(unbalance_deviation(runs, cases[i], kind.name));
    figure.series.push_back(series);
  }
  return {summary_of(settings, runs.size(), "Four wheels unbalanced, all else known; case: coherence^2", rows,
                     lines),
          {figure}};
}

}  // namespace

Study cancellation_study() {
  return {.name = "cancellation",
          .line = "what the road that rear and front wheels share is worth, by their coherence (table 6)",
          .options = kIdealOptions,
          .settings = {{"samples", 50000}},
          .runs = 30,
          .run = run_cancellation,
          .summarise = summarise_cancellation};
}

}  // namespace roadbalance
