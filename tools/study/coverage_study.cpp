#include <algorithm>
#include <cmath>

#include "tools/study/chain_drive.hpp"
#include "tools/study/chain_studies.hpp"
#include "tools/study/ideal_studies.hpp"
#include "tools/study/statistics.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// Quantile of chi^2 with two degrees of freedom: -2 ln(1 - part).
double quantile_of_two(double part) {
  return -2.0 * std::log(1.0 - part);
}

Json run_coverage(const StudyRun& run) {
  ChainDrive drive;
  drive.seconds = run.settings["seconds"].get<double>();
  drive.road_class = run.settings["road"].get<std::string>();
  return {{"seed", run.seed}, {"wheels", chain_errors(drive, run.seed, run.folder)}};
}

/// Percentage of the ellipses of such a probability that hold the truth; one that is not known holds nothing.
double covered(const std::vector<double>& ellipses, double part) {
  const auto inside = std::count_if(ellipses.begin(), ellipses.end(),
                                    [&](double e) { return e >= 0.0 && e <= quantile_of_two(part); });
  return 100.0 * static_cast<double>(inside) / static_cast<double>(ellipses.size());
}

StudyResult summarise_coverage(const Json& settings, const std::vector<Json>& runs) {
  Json rows = Json::array();
  Figure figure{"coverage", "Ellipses that hold the truth", {"stated, %"}, {"found, %"}, {}};
  Series found{"found", {}, {}}, right{"stated", {}, {}, true, false};
  const std::vector<double> ellipses = chain_values(runs, "wheels", -1, "ellipse");
  for (const double part : {0.5, 0.683, 0.8, 0.9, 0.95, 0.99}) {
    Json row{{"stated %", 100.0 * part}, {"covered %", covered(ellipses, part)}};
    for (int w = 0; w < kWheels; ++w)
      row[kWheelNames[static_cast<std::size_t>(w)]] =
          covered(chain_values(runs, "wheels", w, "ellipse"), part);
    rows.push_back(row);
    found.x.push_back(100.0 * part), found.y.push_back(row["covered %"].get<double>());
    right.x.push_back(100.0 * part), right.y.push_back(100.0 * part);
  }
  figure.series = {found, right};
  const Json lines{acceptance_line("ellipses", static_cast<double>(ellipses.size()), 1000.0,
                                   std::numeric_limits<double>::infinity()),
                   acceptance_line("covered by 95 % ellipses, %", covered(ellipses, 0.95), 92.0, 98.0,
                                   answers_among(ellipses))};
  return {{{"runs", runs.size()},
           {"settings", settings},
           {"tables", {{{"title", "Stated ellipses of the unbalances against the truth"}, {"rows", rows}}}},
           {"acceptance", lines},
           {"accepted", all_met(lines)}},
          {figure}};
}

}  // namespace

Study coverage_study() {
  return {.name = "coverage",
          .line = "how often the stated 95 % ellipses hold the truth, with all errors of sensors and rings",
          .options = kIdealOptions,
          .settings = {{"seconds", 40.0}, {"road", "A"}},
          .runs = 250,
          .run = run_coverage,
          .summarise = summarise_coverage};
}

}  // namespace roadbalance
