#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "tools/study/demo_accuracy.hpp"
#include "tools/study/statistics.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
constexpr double kNever = std::numeric_limits<double>::infinity();

/// One wheel of one run against its truth.
struct Errors {
  double truth_g;
  double part;  ///< of the unbalance
  double degrees;
  double tyre_part;
  double sigmas_g;  ///< error in standard deviations
  double sigmas_deg;
};

Errors errors_of(const Json& wheel) {
  Errors errors{wheel["truth_g"].get<double>(), kNever, kNever, kNever, kNever, kNever};
  if (!wheel["unbalance_g"].is_null()) {
    const double grams = std::abs(wheel["unbalance_g"].get<double>() - errors.truth_g);
    errors.part = grams / errors.truth_g;
    errors.degrees =
        std::abs(std::remainder(wheel["angle_deg"].get<double>() - wheel["truth_deg"].get<double>(), 360.0));
    errors.sigmas_g = grams / wheel["sigma_g"].get<double>();
    errors.sigmas_deg = errors.degrees / wheel["sigma_deg"].get<double>();
  }
  if (!wheel["tyre_stiffness_n_m"].is_null()) {
    const double truth = wheel["truth_tyre_stiffness_n_m"].get<double>();
    errors.tyre_part = std::abs(wheel["tyre_stiffness_n_m"].get<double>() - truth) / truth;
  }
  return errors;
}

std::vector<double> values_of(const std::vector<Errors>& wheels, double Errors::*field) {
  std::vector<double> values;
  for (const Errors& wheel : wheels) values.push_back(wheel.*field);
  return values;
}

double part_within_two(const std::vector<Errors>& wheels, double Errors::*field) {
  const auto within =
      std::count_if(wheels.begin(), wheels.end(), [&](const Errors& e) { return e.*field <= 2.0; });
  return static_cast<double>(within) / static_cast<double>(wheels.size());
}

/// The median error, null if half of the wheels are not known.
Json median_line(const std::string& text, const std::vector<Errors>& wheels, double Errors::*field,
                 double unit, double most) {
  const std::vector<double> values = values_of(wheels, field);
  return acceptance_line(text, quantile(values, 0.5) * unit, 0.0, most, answers_among(values));
}

/// Percentage of the wheels that are within two of their standard deviations.
Json within_line(const std::string& text, const std::vector<Errors>& wheels, double Errors::*field) {
  return acceptance_line(text, part_within_two(wheels, field) * 100.0, 85.0, 99.0,
                         answers_among(values_of(wheels, field)));
}

}  // namespace

Json demo_accuracy_summary(const std::vector<Json>& runs) {
  std::vector<Errors> all;
  std::vector<Errors> strong;
  int good_seeds = 0;
  Json seeds = Json::array();
  for (const Json& run : runs) {
    bool good = true;
    Json list = Json::array();
    for (const Json& wheel : run["wheels"]) {
      const Errors e = errors_of(wheel);
      all.push_back(e);
      if (e.truth_g >= 20.0) {
        strong.push_back(e);
        good = good && e.part <= 0.10 && e.degrees <= 6.0;
      }
      list.push_back({{"name", wheel["name"]},
                      {"error_percent", e.part * 100.0},
                      {"error_deg", e.degrees},
                      {"error_tyre_percent", e.tyre_part * 100.0},
                      {"sigmas_g", e.sigmas_g},
                      {"sigmas_deg", e.sigmas_deg}});
    }
    good_seeds += good;
    seeds.push_back({{"seed", run["seed"]}, {"good", good}, {"wheels", list}});
  }
  const double good_part = static_cast<double>(good_seeds) / static_cast<double>(runs.size());
  const Json acceptance{
      acceptance_line("part of seeds with every wheel of 20 g or more within 10 % and 6 deg", good_part, 0.9,
                      1.0, runs.size()),
      median_line("median error of wheels of 20 g or more, %", strong, &Errors::part, 100.0, 3.0),
      median_line("median error of wheels of 20 g or more, deg", strong, &Errors::degrees, 1.0, 2.0),
      median_line("median error of tyre stiffness, %", all, &Errors::tyre_part, 100.0, 3.0),
      within_line("wheels with the true grams within 2 sigma, %", all, &Errors::sigmas_g),
      within_line("wheels with the true degrees within 2 sigma, %", all, &Errors::sigmas_deg)};
  return {{"runs", runs.size()},
          {"good_seeds", good_seeds},
          {"seeds", seeds},
          {"acceptance", acceptance},
          {"accepted", all_met(acceptance)}};
}

}  // namespace roadbalance
