#include <algorithm>
#include <cmath>

#include "tools/study/chain_drive.hpp"
#include "tools/study/chain_studies.hpp"
#include "tools/study/ideal_studies.hpp"
#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// A drive and what the worst wheel's median may be.
struct Row {
  const char* name;
  ChainDrive drive;
  double percent, degrees, grams;
};

std::vector<Row> rows_of() {
  const double any = std::numeric_limits<double>::infinity();
  const ChainDrive b{.road_class = "B"};
  // No multiples of 5 g, for which one weight would be exact.
  const ChainDrive five_minutes{.seconds = 75.0, .unbalance_g = {32.4, 17.6, 27.5, 12.6}};
  return {{"A, 4 x 40 s", {}, 1.5, 0.9, 0.45},
          {"B, 4 x 40 s", b, 2.7, 1.1, any},
          {"A, 4 x 75 s", five_minutes, any, any, any}};
}

Json run_end_to_end(const StudyRun& run) {
  Json result{{"seed", run.seed}};
  for (const Row& row : rows_of()) result[row.name] = chain_errors(row.drive, run.seed, run.folder);
  return result;
}

/// Value of the worst wheel.
double worst(const std::vector<Json>& runs, const char* row, const char* what, double ErrorSizes::*size) {
  double value = 0.0;
  for (int wheel = 0; wheel < kWheels; ++wheel)
    value = std::max(value, sizes_of(chain_values(runs, row, wheel, what)).*size);
  return value;
}

/// Column, and what is asked of the worst wheel's median.
struct LimitColumn {
  const char *what, *median, *p95, *asked;
  double Row::*most;
};
constexpr LimitColumn kColumns[] = {
    {"mass_percent", "mass %, worst median", "mass % p95", "mass, %", &Row::percent},
    {"angle_deg", "angle deg, worst median", "angle deg p95", "angle, deg", &Row::degrees},
    {"residual_g", "residual g, worst median", "residual g p95", "residual vector, g", &Row::grams},
    {"tyre_percent", "ct %, worst median", "ct % p95", "", nullptr},
    {"rounded_g", "after 5 g weights, worst median g", "after 5 g weights p95", "", nullptr}};

/// Median of the worst wheel's error if the estimate were as good as any can be: of a normal distribution
/// 0.6745 of its standard deviation.
double least_median(const std::array<WheelBound, kWheels>& bounds, double WheelBound::*deviation) {
  double worst = 0.0;
  for (const WheelBound& bound : bounds) worst = std::max(worst, 0.6745 * (bound.*deviation));
  return worst;
}

/// How large errors are in how many of the wheels, a line for each drive.
Figure distributions(const std::vector<Json>& runs, const char* name, const char* title, const char* unit,
                     const char* what) {
  Figure figure{name, title, {unit}, {"wheels with no larger error, %"}, {}};
  for (const Row& row : rows_of())
    figure.series.push_back(distribution(row.name, chain_values(runs, row.name, -1, what)));
  return figure;
}

StudyResult summarise_end_to_end(const Json& settings, const std::vector<Json>& runs) {
  Json rows = Json::array(), lines = Json::array();
  for (const Row& row : rows_of()) {
    Json cells{{"case", row.name}};
    for (const LimitColumn& column : kColumns) {
      const double median = worst(runs, row.name, column.what, &ErrorSizes::median);
      cells[column.median] = number_or_null(median);
      cells[column.p95] = number_or_null(worst(runs, row.name, column.what, &ErrorSizes::p95));
      if (column.most == nullptr || !std::isfinite(row.*column.most)) continue;
      std::string text = row.name;
      text.append(": worst wheel's median of the ").append(column.asked);
      lines.push_back(acceptance_line(text, median, 0.0, row.*column.most,
                                      answers_among(chain_values(runs, row.name, -1, column.what))));
    }
    const auto bounds = chain_bound(row.drive);
    cells["mass %, bound of that median"] = least_median(bounds, &WheelBound::mass_percent);
    cells["angle deg, bound"] = least_median(bounds, &WheelBound::angle_deg);
    cells["ct %, bound"] = least_median(bounds, &WheelBound::tyre_percent);
    rows.push_back(cells);
  }
  const auto after = chain_values(runs, rows_of().back().name, -1, "rounded_g");
  const ErrorSizes rounded = sizes_of(after);
  lines.push_back(acceptance_line("5 minutes, weights in steps of 5 g: residual in the median, g",
                                  rounded.median, 0.0, 4.0, answers_among(after)));
  lines.push_back(acceptance_line("5 minutes, weights in steps of 5 g: residual in 95 % of the wheels, g",
                                  rounded.p95, 0.0, 7.0, answers_among(after)));
  return {
      {{"runs", runs.size()},
       {"settings", settings},
       {"tables",
        {{{"title",
           "The whole chain: noise, 16 bit, pitch errors, parameters drawn; 30, 20, 25, 15 g (5 minutes: "
           "32.4, 17.6, 27.5, 12.6)"},
          {"rows", rows}}}},
       {"acceptance", lines},
       {"accepted", all_met(lines)}},
      {distributions(runs, "end-to-end-mass", "Errors of the masses", "%", "mass_percent"),
       distributions(runs, "end-to-end-angle", "Errors of the angles", "deg", "angle_deg"),
       distributions(runs, "end-to-end-residual", "What an ideal counterweight leaves", "g", "residual_g"),
       distributions(runs, "end-to-end-rounded", "What weights in steps of 5 g leave", "g", "rounded_g")}};
}

}  // namespace

Study end_to_end_study() {
  return {.name = "end-to-end",
          .line = "the whole chain from simulated converters and pulses to weights (table 11)",
          .options = kIdealOptions,
          .settings = Json::object(),
          .runs = 20,
          .run = run_end_to_end,
          .summarise = summarise_end_to_end};
}

}  // namespace roadbalance
