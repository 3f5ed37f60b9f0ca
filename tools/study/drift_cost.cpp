#include "tools/study/drift_cost.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

#include "embedded/demo_vehicle.hpp"
#include "tools/study/simulated_drive.hpp"
#include "tools/views/wheels_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDrift_km_h_min = 5.0, kBegin_km_h = 98.7, kDrift_s = 320.0;
constexpr int kDriftSteps = 8;
constexpr double kAllowed_percent = 0.1, kAllowedChange_deg = 0.05;
constexpr std::array kDriftAngle_deg{217, 60, 305, 128};

std::string plateau(double speed_km_h, double seconds) {
  return "[[drive.plateau]]\nspeed_km_h = " + std::to_string(speed_km_h) +
         "\nseconds = " + std::to_string(seconds) + "\n";
}

std::string rest_of_scenario() {
  std::string text = "[road]\nclass = \"S\"\nrear_coherence2 = 0.95\n";
  for (std::size_t w = 0; w < kWheels; ++w)
    text += "[[unbalance]]\nwheel = \"" + std::string(kWheelNames[w]) +
            "\"\nmass_g = 60\nangle_deg = " + std::to_string(kDriftAngle_deg[w]) + "\n";
  return text;
}

std::string drifting() {
  return "[drive]\nwander_km_h = 0\ndrift_km_h_min = " + std::to_string(kDrift_km_h_min) + "\n" +
         plateau(kBegin_km_h, kDrift_s) + rest_of_scenario();
}

/// The same speeds, in steps.
std::string stepping() {
  std::string text = "[drive]\nwander_km_h = 0\n";
  for (int step = 0; step < kDriftSteps; ++step) {
    const double minutes = (step + 0.5) * kDrift_s / kDriftSteps / 60.0;
    text += plateau(kBegin_km_h + kDrift_km_h_min * minutes, kDrift_s / kDriftSteps);
  }
  return text + rest_of_scenario();
}

Json wheels_of(const VehicleConfig& vehicle, const std::string& scenario, const std::filesystem::path& file,
               std::uint64_t seed) {
  std::ofstream(file) << scenario;  // one that is not written is not found
  const DriveEstimate estimate =
      identify_simulated_drive(vehicle, file.string() + "?seed=" + std::to_string(seed) + "&rate=max");
  return wheels_json(estimate.identification, estimate.balance);
}

struct Mean {
  double value = std::numeric_limits<double>::quiet_NaN();
  double standard_error = std::numeric_limits<double>::infinity();
};

/// Mean of the seeds' means over their wheels; nothing is known if a wheel is not.
Mean mean_of(const std::vector<Json>& runs, const std::string& key) {
  double sum = 0.0, square = 0.0;
  for (const Json& run : runs) {
    double of_seed = 0.0;
    for (const Json& wheel : run["wheels"]) {
      if (!wheel[key].is_number()) return {};
      of_seed += wheel[key].get<double>() / kWheels;
    }
    sum += of_seed;
    square += of_seed * of_seed;
  }
  const auto n = static_cast<double>(runs.size());
  if (n < 2.0) return {n == 1.0 ? sum : std::numeric_limits<double>::quiet_NaN()};
  return {sum / n, std::sqrt(std::max(0.0, square / n - sum * sum / n / n) / (n - 1.0))};
}

Json line(const std::string& text, const Mean& mean, double allowed, std::size_t seeds) {
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  return {{"line", text},
          {"value", number(mean.value)},
          {"standard_error", number(mean.standard_error)},
          {"required", {-allowed, allowed}},
          {"answers", seeds * kWheels},
          {"met", std::abs(mean.value) + 2.0 * mean.standard_error <= allowed}};
}

}  // namespace

Json drift_cost_run(std::uint64_t seed, const std::filesystem::path& folder) {
  const auto vehicle = VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml");
  const auto file = [&](const char* name) { return folder / (name + std::to_string(seed) + ".toml"); };
  const Json steps = wheels_of(vehicle, stepping(), file("stepping-"), seed);
  const Json drift = wheels_of(vehicle, drifting(), file("drifting-"), seed);
  Json wheels = Json::array();
  for (std::size_t w = 0; w < kWheels; ++w) {
    const bool known = steps[w]["unbalance_g"].is_number() && drift[w]["unbalance_g"].is_number();
    const auto of = [&](const Json& of_drive, const char* key) { return of_drive[w][key].get<double>(); };
    wheels.push_back(
        {{"name", kWheelNames[w]},
         {"change_percent",
          known ? Json(100.0 * (of(drift, "unbalance_g") / of(steps, "unbalance_g") - 1.0)) : Json()},
         {"change_deg",
          known ? Json(std::remainder(of(drift, "angle_deg") - of(steps, "angle_deg"), 360.0)) : Json()}});
  }
  return {{"seed", seed}, {"wheels", wheels}};
}

Json drift_cost_summary(const std::vector<Json>& runs) {
  const Json grams = line("mean change of the identified unbalance, %", mean_of(runs, "change_percent"),
                          kAllowed_percent, runs.size());
  const Json degrees =
      line("mean change of its angle, deg", mean_of(runs, "change_deg"), kAllowedChange_deg, runs.size());
  return {{"runs", runs.size()},
          {"seeds", runs},
          {"acceptance", {grams, degrees}},
          {"accepted", grams["met"].get<bool>() && degrees["met"].get<bool>()}};
}

}  // namespace roadbalance
