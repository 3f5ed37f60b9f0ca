#include "tools/study/identify_with.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <complex>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/command_line/exit_code.hpp"
#include "common/config/section.hpp"
#include "common/text/format.hpp"
#include "common/types/angle_units.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/analysis/identify/assemble.hpp"
#include "host/analysis/identify/estimators/estimator.hpp"
#include "host/analysis/identify/publish_estimate.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "tools/views/identification_json.hpp"
#include "tools/views/number_json.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/recording_defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// The answer of an estimator, and the drive that it rests on.
struct Told {
  EstimatorAnswer answer;
  int stretches = 0;
  double seconds = 0.0;
};

Told ask(const std::string& name, const Question& question, const std::string& folder, bool refine,
         RecordingDefects& defects) {
  Told told;
  const auto estimator = make_estimator(name, question);
  defects = collect_stretches(folder, refine, [&](const Stretch& stretch) {
    estimator->add(stretch);
    ++told.stretches;
    told.seconds += stretch.seconds();
  });
  told.answer = estimator->solve();
  return told;
}

void refuse_without_road(const EstimatorKind& kind, const VehicleConfig& vehicle) {
  if (kind.road_measured && !measures_road(vehicle))
    throw ConfigError(
        "estimator " + kind.name +
        " needs a measured road: this record's vehicle.toml has no channel of role road at every "
        "wheel");
}

Question of_suspension(const VehicleConfig& vehicle) {
  return {geometry_of(vehicle.model), nominal_parameters(vehicle), suspension_unknowns()};
}

/// Tyres and the unbalances of wheels with an encoder, with the identified suspension.
Question of_wheels(const VehicleConfig& vehicle, const EstimatorAnswer& suspension) {
  Question question = of_suspension(vehicle);
  question.asked.reset();
  for (int p = 0; p < kEstimatedTyre; ++p)
    if (std::isfinite(suspension.x(p))) question.known(kSpring + p) = suspension.x(p);
  for (std::size_t i = 0; i < kWheels; ++i) {
    question.asked.set(kEstimatedTyre + i);
    if (vehicle.wheel[i].node.empty()) continue;
    question.asked.set(kEstimatedUnbalance + 2 * i);
    question.asked.set(kEstimatedUnbalance + 2 * i + 1);
  }
  return question;
}

/// An unbalance as mass at the weights' radius, with its standard deviations along and across.
struct Mass {
  double mass_g, angle_deg, sigma_g, sigma_deg;
};
Mass mass_of(const EstimatorAnswer& answer, int wheel, double radius_m) {
  const int at = kEstimatedUnbalance + 2 * wheel;
  const Eigen::Vector2d grams = 1000.0 / radius_m * answer.x.segment<2>(at);
  const Eigen::Matrix2d covariance = std::pow(1000.0 / radius_m, 2) * answer.covariance.block<2, 2>(at, at);
  const Eigen::Vector2d radial = grams.normalized(), tangential(-radial.y(), radial.x());
  const double angle = std::atan2(grams.y(), grams.x()) * kDegrees;
  return {grams.norm(), angle < 0.0 ? angle + 360.0 : angle, std::sqrt(radial.dot(covariance * radial)),
          std::sqrt(tangential.dot(covariance * tangential)) / grams.norm() * kDegrees};
}

double sigma(const EstimatorAnswer& answer, int i) {
  return std::sqrt(answer.covariance(i, i));
}

/// Whether the estimator went by the tyre that vehicle.toml has: one that it was asked for and is exact, or
/// that it does not report although it reports an unbalance.
bool takes_tyre(const EstimatorAnswer& answer, int wheel) {
  const int tyre = kEstimatedTyre + wheel;
  if (std::isfinite(answer.x(tyre))) return answer.covariance(tyre, tyre) == 0.0;
  const auto unbalances = answer.x.tail<2 * kWheels>();
  return (unbalances.array().isFinite() && unbalances.array() != 0.0).any();
}

void remark_on_tyres(EstimatorAnswer& answer) {
  for (int i = 0; i < kWheels; ++i)
    if (takes_tyre(answer, i)) {
      answer.diagnostics.emplace_back("± takes the tyres of vehicle.toml for exact");
      return;
    }
}

/// "1.2", "-" for none.
std::string shown(const char* form, double value) {
  return std::isfinite(value) ? format(form, value) : "-";
}

/// Springs, dampers and stabilisers in the form of the product's own estimate.
Identification suspension_of(const EstimatorAnswer& answer) {
  Identification result;
  result.state = Unknown::kNone;
  put_suspension(answer.x, answer.covariance.diagonal().cwiseSqrt(), result);
  return result;
}

Json wheels_json(const EstimatorAnswer& answer, const VehicleConfig& vehicle) {
  Json wheels = Json::array();
  const ParameterVector nominal = nominal_parameters(vehicle);
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    const bool turns = !vehicle.wheel[w].node.empty();
    const Mass mass = mass_of(answer, i, vehicle.wheel[w].weight_radius_m);
    const auto of_mass = [&](double value) { return turns ? number_or_null(value) : Json(nullptr); };
    const bool taken = takes_tyre(answer, i);
    const double tyre = taken ? nominal(kTyre + i) : answer.x(kEstimatedTyre + i);
    wheels.push_back({{"name", kWheelNames[w]},
                      {"unbalance_g", of_mass(mass.mass_g)},
                      {"angle_deg", of_mass(mass.angle_deg)},
                      {"sigma_g", of_mass(mass.sigma_g)},
                      {"sigma_deg", of_mass(mass.sigma_deg)},
                      {"tyre_stiffness_n_m", number_or_null(tyre)},
                      {"sigma_tyre_stiffness_n_m",
                       taken ? Json(nullptr) : number_or_null(sigma(answer, kEstimatedTyre + i))},
                      {"tyre_from", taken ? "vehicle.toml" : "drive"}});
  }
  return wheels;
}

void print_wheels(const EstimatorAnswer& answer, const VehicleConfig& vehicle) {
  const ParameterVector nominal = nominal_parameters(vehicle);
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    if (takes_tyre(answer, i))
      std::printf("%-12s  tyre %6.1f kN/m as vehicle.toml has it", kWheelNames[w], nominal(kTyre + i) / 1e3);
    else
      std::printf("%-12s  tyre %6s ± %4s kN/m", kWheelNames[w],
                  shown("%.1f", answer.x(kEstimatedTyre + i) / 1e3).c_str(),
                  shown("%.1f", shown_sigma(sigma(answer, kEstimatedTyre + i) / 1e3, 0.1)).c_str());
    const Mass mass = mass_of(answer, i, vehicle.wheel[w].weight_radius_m);
    if (vehicle.wheel[w].node.empty())
      std::printf("  no encoder\n");
    else
      std::printf("  %5s ± %4s g  at %5s ± %4s°\n", shown("%.1f", mass.mass_g).c_str(),
                  shown("%.1f", shown_sigma(mass.sigma_g, 0.1)).c_str(),
                  shown("%.1f", mass.angle_deg).c_str(),
                  shown("%.1f", shown_sigma(mass.sigma_deg, 0.1)).c_str());
  }
}

}  // namespace

int identify_with(const std::string& estimator, const std::string& folder, bool refine, bool json) {
  const VehicleConfig vehicle = vehicle_of_recording(folder);
  const EstimatorKind& kind = estimator_kind(estimator);
  refuse_without_road(kind, vehicle);
  const bool chassis = estimator == "chassis";
  RecordingDefects defects;
  const Told suspension = ask("chassis", of_suspension(vehicle), folder, refine, defects);
  warn_of_defects("identify", folder, defects);
  Told told =
      chassis ? suspension : ask(estimator, of_wheels(vehicle, suspension.answer), folder, refine, defects);
  if (!chassis) {
    remark_on_tyres(told.answer);
    told.answer.diagnostics.emplace_back("± takes springs, dampers and stabilisers as told here for exact");
  }
  bool any = false;
  for (int i = chassis ? 0 : kEstimatedTyre; i < (chassis ? kEstimatedTyre : kUnknowns); ++i)
    any = any || (std::isfinite(told.answer.x(i)) && told.answer.covariance(i, i) > 0.0);
  if (json) {
    Json result{{"estimator", estimator},
                {"stretches", told.stretches},
                {"seconds", told.seconds},
                {"suspension", suspension_json(suspension_of(suspension.answer))}};
    if (!chassis) result["wheels"] = wheels_json(told.answer, vehicle);
    result["remarks"] = told.answer.diagnostics;
    std::printf("%s\n", result.dump().c_str());
  } else {
    std::printf("%s, from %.0f s of steady driving in %d stretches\n", estimator.c_str(), told.seconds,
                told.stretches);
    for (const std::string& line : suspension_lines(suspension_of(suspension.answer)))
      std::printf("%s\n", line.c_str());
    if (!chassis) print_wheels(told.answer, vehicle);
    for (const std::string& remark : told.answer.diagnostics) std::printf("%s\n", remark.c_str());
  }
  return any ? kDone : kAnswerIsNo;
}

void add_identify_with(CLI::App& app, int& code) {
  struct Options {
    std::string folder, estimator;
    bool refine = false, json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("identify", "Puts a recorded drive to one estimator");
  command->add_option("folder", options->folder, "the recording")->required();
  std::string kinds;
  for (const EstimatorKind& kind : estimators()) kinds += "\n  " + kind.name + ": " + kind.what;
  command->add_option("--estimator", options->estimator, "which:" + kinds)->required();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->add_flag(
      "--refine", options->refine,
      "compute the relations of the nodes' clocks and the wheels' angles again, as rb identify does");
  command->footer(
      "Exit codes: 0 done, 1 no wheel is identified, 2 usage or another car, 4 cannot read.\n\n"
      "rb identify --estimator NAME calls it.");
  command->callback([options, &code] {
    code = identify_with(options->estimator, options->folder, options->refine, options->json);
  });
}

}  // namespace roadbalance
