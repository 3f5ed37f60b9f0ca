#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/study/ideal_studies.hpp"
#include "tools/study/many_drives.hpp"
#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

const char* const kAlike = "alike";
const char* const kDiffer = "differ";

Json run_many_drives(const StudyRun& run) {
  const auto number = [&](const char* key) { return run.settings[key].get<double>(); };
  ManyDrives drives{.drives = run.settings["drives"].get<int>(), .seconds = number("seconds")};
  Json result{{"seed", run.seed}, {kAlike, many_drives_run(drives, run.seed)}};
  drives.tyre_percent = number("tyre_percent");
  drives.unbalance_g = number("unbalance_g");
  result[kDiffer] = many_drives_run(drives, run.seed);
  return result;
}

/// One kind of number of all runs and wheels; NaN where nothing is known.
std::vector<double> values(const std::vector<Json>& runs, const char* car, const std::string& key,
                           const char* what) {
  std::vector<double> all;
  const auto add = [&](const Json& value) {
    all.push_back(value.is_number() ? value.get<double>() : std::nan(""));
  };
  for (const Json& run : runs)
    for (const Json& wheel : run[car][key]) {
      if (wheel[what].is_array())
        for (const Json& value : wheel[what]) add(value);
      else
        add(wheel[what]);
    }
  return all;
}

double rms(const std::vector<double>& all) {
  double sum = 0.0;
  for (const double value : all) sum += value * value;
  return std::sqrt(sum / static_cast<double>(all.size()));
}

/// Percentage of values no larger in size; unknown ones are larger.
double within(const std::vector<double>& all, double most) {
  const auto inside =
      std::count_if(all.begin(), all.end(), [&](double one) { return std::abs(one) <= most; });
  return 100.0 * static_cast<double>(inside) / static_cast<double>(all.size());
}

const double kEllipse95 = -2.0 * std::log(0.05);  // quantile of chi^2 with two degrees of freedom
constexpr double kTwoSigma = 0.9545;

Json row_of(const std::vector<Json>& runs, const char* car, const std::string& key) {
  const auto of = [&](const char* what) { return values(runs, car, key, what); };
  return {{"car", car},
          {"put together", key},
          {"unbalance rms g", number_or_null(rms(of("off_g")))},
          {"stated g", number_or_null(rms(of("sigma_g")))},
          {"in 95 % ellipse, %", within(of("ellipse"), kEllipse95)},
          {"tyre rms %", number_or_null(rms(of("tyre_percent")))},
          {"tyre in 2 sigma, %", within(of("tyre_sigmas"), 2.0)},
          {"widened by, median", number_or_null(std::sqrt(std::max(1.0, quantile(of("ratio"), 0.5))))}};
}

/// Errors of independent drives fall as 1 / sqrt(drives).  The ratio of two root mean squares of n
/// independent numbers each scatters by 1 / sqrt(n) of itself; four times that is allowed.
Json falling(const std::vector<Json>& runs, const char* car, const std::vector<int>& sizes, const char* what,
             const std::string& name) {
  const auto few = values(runs, car, joined_key(Joined::kProduct, sizes.front()), what);
  const auto all = values(runs, car, joined_key(Joined::kProduct, sizes.back()), what);
  const double expected = std::sqrt(static_cast<double>(sizes.back()) / sizes.front());
  const double allowed = std::exp(4.0 / std::sqrt(static_cast<double>(all.size())));
  return acceptance_line(std::string(car) + ": " + name + ": error of " + std::to_string(sizes.front()) +
                             " drives by that of " + std::to_string(sizes.back()),
                         rms(few) / rms(all), expected / allowed, expected * allowed, answers_among(all));
}

/// Benefit of dividing each drive's equations by the level of its road.
Json gain_by_road(const std::vector<Json>& runs, const char* car, int size) {
  const auto of = [&](Joined joined) { return values(runs, car, joined_key(joined, size), "tyre_percent"); };
  const auto ours = of(Joined::kProduct);
  return acceptance_line(std::string(car) + ": tyres: error of plain sums by that of the product",
                         rms(of(Joined::kPlainSums)) / rms(ours), 1.0,
                         std::numeric_limits<double>::infinity(), answers_among(ours));
}

void judge_car(const std::vector<Json>& runs, const char* car, const std::vector<int>& sizes, Json& lines) {
  lines.push_back(falling(runs, car, sizes, "off_g", "unbalances"));
  lines.push_back(falling(runs, car, sizes, "tyre_percent", "tyres"));
  lines.push_back(gain_by_road(runs, car, sizes.back()));
  for (const int size : sizes) {
    const std::string key = joined_key(Joined::kProduct, size);
    const std::string of_so_many = std::string(car) + ", " + std::to_string(size) + " drives: ";
    const auto ellipses = values(runs, car, key, "ellipse"), tyres = values(runs, car, key, "tyre_sigmas");
    lines.push_back(share_line(of_so_many + "unbalances in their 95 % ellipses, %",
                               within(ellipses, kEllipse95), 0.95, answers_among(ellipses)));
    lines.push_back(share_line(of_so_many + "tyres within 2 sigma, %", within(tyres, 2.0), kTwoSigma,
                               answers_among(tyres)));
  }
}

Figure errors_by_drives(const std::vector<Json>& runs, const std::vector<int>& sizes) {
  Figure figure{
      "many-drives", "Error of the unbalances", {"drives", true}, {"rms of a component, g", true}, {}};
  for (const char* car : {kAlike, kDiffer})
    for (const char* what : {"off_g", "sigma_g"}) {
      const bool stated = std::string(what) == "sigma_g";
      Series series{std::string(car) + (stated ? ", stated" : ", found"), {}, {}, stated, !stated};
      for (const int size : sizes) {
        series.x.push_back(size);
        series.y.push_back(rms(values(runs, car, joined_key(Joined::kProduct, size), what)));
      }
      figure.series.push_back(series);
    }
  return figure;
}

StudyResult summarise_many_drives(const Json& settings, const std::vector<Json>& runs) {
  const std::vector<int> sizes = joined_sizes(settings["drives"].get<int>());
  Json rows = Json::array(), lines = Json::array();
  for (const char* car : {kAlike, kDiffer}) {
    for (const Joined joined : kJoined)
      for (const int size : sizes) rows.push_back(row_of(runs, car, joined_key(joined, size)));
    judge_car(runs, car, sizes, lines);
  }
  return {{{"runs", runs.size()},
           {"settings", settings},
           {"tables",
            {{{"title",
               "One estimate from many drives on roads A, B, A, C: a car that stays alike, and one that "
               "differs from drive to drive"},
              {"rows", rows}}}},
           {"acceptance", lines},
           {"accepted", all_met(lines)}},
          {errors_by_drives(runs, sizes)}};
}

}  // namespace

Study many_drives_study() {
  return {.name = "many-drives",
          .line = "one estimate from many drives of one car: does it get better as it says",
          .options = kIdealOptions,
          .settings = {{"drives", 16}, {"seconds", 40.0}, {"tyre_percent", 3.0}, {"unbalance_g", 1.0}},
          .runs = 40,
          .run = run_many_drives,
          .summarise = summarise_many_drives};
}

}  // namespace roadbalance
