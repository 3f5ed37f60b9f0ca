#include <Eigen/LU>
#include <cmath>
#include <complex>

#include "common/bus/results.hpp"
#include "tools/study/chain_drive.hpp"
#include "tools/study/chain_studies.hpp"
#include "tools/study/cramer_rao.hpp"
#include "tools/study/estimator_trial.hpp"
#include "tools/study/ideal_studies.hpp"
#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
const char* const kNarrow = "110 .. 130 km/h";
const char* const kMiddle = "80 .. 130 km/h";
const char* const kWide = "60 .. 140 km/h";

std::vector<double> speeds_of(const std::string& name) {
  if (name == kNarrow) return {110.0, 116.7, 123.3, 130.0};
  if (name == kMiddle) return {80.0, 96.7, 113.3, 130.0};
  return {60.0, 80.0, 100.0, 120.0, 140.0};
}

Json run_radial_force(const StudyRun& run) {
  Json result{{"seed", run.seed}};
  for (const char* name : {kNarrow, kWide}) {
    ChainDrive drive;
    drive.speeds_km_h = speeds_of(name);
    drive.seconds = run.settings["seconds"].get<double>();
    drive.radial_force_n.fill(run.settings["force_n"].get<double>());
    result[name] = chain_errors(drive, run.seed, run.folder);
  }
  return result;
}

/// Least standard deviation, per axis, of U and of the force of a wheel whose tyre is known, 160 s in all on
/// an independent class A road: information T / (2 S_F) [Om^4 Om^2; Om^2 1] a speed.
Json bound_row(const std::string& name) {
  const ParameterVector car = nominal_parameters(demo_vehicle());
  const RoadStatistics road{.rear_coherence2 = 0.0};
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  const auto speeds = speeds_of(name);
  for (const double speed_km_h : speeds) {
    const double om = speed_km_h / 3.6 / 0.30;
    const Eigen::Vector2d share(om * om, 1.0);
    const double force = car(kTyre) * car(kTyre) * road.density(om, speed_km_h / 3.6);
    information += 160.0 / static_cast<double>(speeds.size()) / (2.0 * force) * share * share.transpose();
  }
  const Eigen::Matrix2d covariance = information.inverse();
  const double unbalance = 0.030 * 0.19;
  return {{"case", name},
          {"sd of U alone %", 100.0 / unbalance / std::sqrt(information(0, 0))},
          {"sd of U with the force %", 100.0 / unbalance * std::sqrt(covariance(0, 0))},
          {"sd of the force N", std::sqrt(covariance(1, 1))}};
}

/// Answers for the wheels of all runs.
struct Answered {
  std::size_t wheels = 0;
  std::size_t refused = 0;                    ///< without an unbalance
  std::size_t separated = 0, equivalent = 0;  ///< of the others
  double percent(std::size_t part) const {
    return 100.0 * static_cast<double>(part) / static_cast<double>(wheels);
  }
};

Answered answered(const std::vector<Json>& runs, const char* name) {
  Answered count;
  for (const Json& run : runs)
    for (const Json& wheel : run[name]) {
      ++count.wheels;
      if (!wheel["told"].get<bool>()) {
        ++count.refused;
        continue;
      }
      const auto state = static_cast<ForceState>(wheel["force_state"].get<int>());
      count.separated += state == ForceState::kSeparated ? 1 : 0;
      count.equivalent += state == ForceState::kNotSeparable ? 1 : 0;
    }
  return count;
}

/// Percentage of the answers whose error is at most two printed standard deviations long; an answer is one
/// that has both.
struct WithinTwo {
  double percent;
  std::size_t answers;
};
WithinTwo within_two(const std::vector<Json>& runs, const char* name, const char* error, const char* sigma) {
  const auto errors = chain_values(runs, name, -1, error), sigmas = chain_values(runs, name, -1, sigma);
  std::size_t answers = 0, count = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (!std::isfinite(errors[i]) || !std::isfinite(sigmas[i])) continue;
    ++answers;
    count += errors[i] <= 2.0 * sigmas[i] ? 1 : 0;
  }
  return {100.0 * static_cast<double>(count) / static_cast<double>(answers), answers};
}

Json row_of(const std::vector<Json>& runs, const char* name) {
  const auto median = [&](const char* what) {
    return number_or_null(sizes_of(chain_values(runs, name, -1, what)).median);
  };
  const Answered count = answered(runs, name);
  return {{"case", name},
          {"wheels", count.wheels},
          {"refused", count.refused},
          {"not separable, % of wheels", count.percent(count.equivalent)},
          {"separated, % of wheels", count.percent(count.separated)},
          {"separated", count.separated},
          {"equivalent less unbalance alone, median g", median("residual_g")},
          {"unbalance alone off, median g", median("alone_residual_g")},
          {"its printed sigma g", median("sigma_alone_g")},
          {"force off, median N", median("force_error_n")},
          {"its printed sigma N", median("sigma_force_n")}};
}

/// How large the errors are where the speeds separate, beside what two normal components of that standard
/// deviation make of it.
Figure in_sigmas(const std::vector<Json>& runs) {
  Figure figure{"radial-force",
                std::string("Errors of what is separated, ") + kWide,
                {"error in printed standard deviations"},
                {"wheels with no larger error, %"},
                {}};
  const auto add = [&](const char* name, const char* error, const char* sigma) {
    const auto errors = chain_values(runs, kWide, -1, error), sigmas = chain_values(runs, kWide, -1, sigma);
    std::vector<double> ratio;
    for (std::size_t i = 0; i < errors.size(); ++i)
      if (std::isfinite(errors[i]) && std::isfinite(sigmas[i])) ratio.push_back(errors[i] / sigmas[i]);
    figure.series.push_back(distribution(name, ratio));
  };
  add("unbalance alone", "alone_residual_g", "sigma_alone_g");
  add("force", "force_error_n", "sigma_force_n");
  Series right{"as printed", {}, {}, true, false};
  for (int k = 0; k <= 40; ++k) {
    const double x = 0.1 * k;
    right.x.push_back(x), right.y.push_back(-100.0 * std::expm1(-0.5 * x * x));
  }
  figure.series.push_back(right);
  return figure;
}

StudyResult summarise_radial_force(const Json& settings, const std::vector<Json>& runs) {
  const Json rows{row_of(runs, kNarrow), row_of(runs, kWide)};
  const Json bounds{bound_row(kNarrow), bound_row(kMiddle), bound_row(kWide)};
  // An error in two dimensions is within two standard deviations of its components with 1 - e^-2, 86 %.
  const auto within = [&](const char* line, const char* error, const char* sigma) {
    const WithinTwo share = within_two(runs, kWide, error, sigma);
    return share_line(line, share.percent, -std::expm1(-2.0), share.answers);
  };
  // A wheel that was refused has no answer: it counts against these two lines.
  const Answered narrow = answered(runs, kNarrow), wide = answered(runs, kWide);
  const Json lines{
      acceptance_line("110 .. 130 km/h: wheels of which 'not separable' is said, %",
                      narrow.percent(narrow.equivalent), 100.0, 100.0, narrow.wheels - narrow.refused),
      acceptance_line("60 .. 140 km/h: wheels whose force is separated, %", wide.percent(wide.separated),
                      90.0, 100.0, wide.wheels - wide.refused),
      within("60 .. 140 km/h: unbalance alone within two printed sigmas, % of the separated",
             "alone_residual_g", "sigma_alone_g"),
      within("60 .. 140 km/h: force within two printed sigmas, % of the separated", "force_error_n",
             "sigma_force_n")};
  return {{{"runs", runs.size()},
           {"settings", settings},
           {"tables",
            {{{"title", "Least standard deviations (30 g, 160 s in all, class A, independent roads)"},
              {"rows", bounds}},
             {{"title", "The whole chain with a radial force on each wheel"}, {"rows", rows}}}},
           {"acceptance", lines},
           {"accepted", all_met(lines)}},
          {in_sigmas(runs)}};
}

}  // namespace

Study radial_force_study() {
  return {.name = "radial-force",
          .line = "unbalance beside a radial force that does not grow with speed (table 8)",
          .options = kIdealOptions,
          .settings = {{"seconds", 40.0}, {"force_n", 30.0}},
          .runs = 20,
          .run = run_radial_force,
          .summarise = summarise_radial_force};
}

}  // namespace roadbalance
