#include <algorithm>
#include <cmath>

#include "host/analysis/identify/confidence.hpp"
#include "tools/study/chain_drive.hpp"
#include "tools/study/real_drive.hpp"
#include "tools/study/real_studies.hpp"
#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

const std::vector<std::string> kRealOptions{"--runs", "--seed", "--state", "--jobs", "--set", "--markdown"};

RealDrive drive_of(const Json& settings) {
  RealDrive drive;
  drive.seconds = settings["seconds"].get<double>();
  drive.road_class = settings["road"].get<std::string>();
  return drive;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  std::size_t known = 0;
  for (const double value : values)
    if (std::isfinite(value)) sum += value, ++known;
  return known > 0 ? sum / static_cast<double>(known) : std::nan("");
}

double percent_inside(const std::vector<double>& ellipses) {
  const auto inside =
      std::count_if(ellipses.begin(), ellipses.end(), [](double e) { return e <= kChiSquared95; });
  return 100.0 * static_cast<double>(inside) / static_cast<double>(answers_among(ellipses));
}

/// A row of bias, scatter, coverage and drives without an answer.
Json row_of(const std::vector<Json>& runs, const std::string& name) {
  const auto values = [&](const char* what) { return chain_values(runs, name, -1, what); };
  const std::vector<double> mass = values("mass_percent"), angle = values("angle_deg");
  const std::size_t answers = answers_among(mass);
  return {{"hazard", name},
          {"answers", answers},
          {"refused %", 100.0 * (1.0 - static_cast<double>(answers) / static_cast<double>(mass.size()))},
          {"mass mean %", number_or_null(mean(mass))},
          {"median", number_or_null(sizes_of(mass).median)},
          {"printed", number_or_null(sizes_of(values("sigma_percent")).median)},
          {"angle mean deg", number_or_null(mean(angle))},
          {"median deg", number_or_null(sizes_of(angle).median)},
          {"printed deg", number_or_null(sizes_of(values("sigma_deg")).median)},
          {"inside %", number_or_null(percent_inside(values("ellipse")))},
          {"alone inside %", number_or_null(percent_inside(values("alone_ellipse")))},
          {"force inside %", number_or_null(percent_inside(values("force_ellipse")))},
          {"force sigma N", number_or_null(sizes_of(values("sigma_force_n")).median)},
          {"tyre mean %", number_or_null(mean(values("tyre_percent")))}};
}

Json run_hazards(const StudyRun& run) {
  Json result{{"seed", run.seed}};
  const std::string only = run.settings["only"].get<std::string>();
  for (const Hazard& hazard : hazards()) {
    if (!only.empty() && hazard.name.find(only) == std::string::npos) continue;
    RealDrive drive = drive_of(run.settings);
    drive.hazard = hazard;
    result[hazard.name] = real_drive_errors(drive, run.seed, run.folder);
  }
  return result;
}

StudyResult summarise_hazards(const Json& settings, const std::vector<Json>& runs) {
  Json rows = Json::array(), lines = Json::array();
  for (const Hazard& hazard : hazards()) {
    if (runs.empty() || !runs.front().contains(hazard.name)) continue;
    const Json row = row_of(runs, hazard.name);
    rows.push_back(row);
    lines.push_back(share_line(hazard.name + ": 95 % ellipses that hold the correction",
                               row["inside %"].is_number() ? row["inside %"].get<double>() : std::nan(""),
                               0.95, row["answers"].get<std::size_t>()));
  }
  return {{{"runs", runs.size()},
           {"settings", settings},
           {"tables", {{{"title", "One hazard at a time, the whole chain"}, {"rows", rows}}}},
           {"acceptance", lines},
           {"accepted", all_met(lines)}},
          {}};
}

Json run_real_road(const StudyRun& run) {
  RealDrive drive = drive_of(run.settings);
  drive.hazard = real_road();
  return {{"seed", run.seed}, {drive.hazard.name, real_drive_errors(drive, run.seed, run.folder)}};
}

StudyResult summarise_real_road(const Json& settings, const std::vector<Json>& runs) {
  const std::string& name = real_road().name;
  const Json row = row_of(runs, name);
  const auto ellipses = chain_values(runs, name, -1, "ellipse");
  const auto alone = chain_values(runs, name, -1, "alone_ellipse");
  const Json lines{acceptance_line("95 % ellipses that hold the correction, %", percent_inside(ellipses),
                                   92.0, 98.0, answers_among(ellipses)),
                   acceptance_line("95 % ellipses that hold the unbalance alone, %", percent_inside(alone),
                                   92.0, 98.0, answers_among(alone)),
                   acceptance_line("drives refused, %", row["refused %"].get<double>(), 0.0, 5.0),
                   acceptance_line("median error of the correction's mass, %",
                                   sizes_of(chain_values(runs, name, -1, "mass_percent")).median, 0.0, 2.0,
                                   answers_among(ellipses)),
                   acceptance_line("median error of its angle, deg",
                                   sizes_of(chain_values(runs, name, -1, "angle_deg")).median, 0.0, 1.0,
                                   answers_among(ellipses))};
  return {{{"runs", runs.size()},
           {"settings", settings},
           {"tables", {{{"title", "Every hazard drawn at once, the whole chain"}, {"rows", {row}}}}},
           {"acceptance", lines},
           {"accepted", all_met(lines)}},
          {}};
}

}  // namespace

Study hazards_study() {
  return {.name = "hazards",
          .line = "the posterior where one thing at a time is not as in an ideal car",
          .options = kRealOptions,
          .settings = {{"seconds", 60.0}, {"road", "A"}, {"only", ""}},
          .runs = 10,
          .run = run_hazards,
          .summarise = summarise_hazards};
}

Study real_road_study() {
  return {.name = "real-road",
          .line = "the posterior on cars and roads of which everything is drawn",
          .options = kRealOptions,
          .settings = {{"seconds", 60.0}, {"road", "A"}},
          .runs = 40,
          .run = run_real_road,
          .summarise = summarise_real_road};
}

}  // namespace roadbalance
