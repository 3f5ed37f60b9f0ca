#include "tools/study/chain_drive.hpp"

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <fstream>

#include "common/types/angle_units.hpp"
#include "host/analysis/balance/compensate.hpp"
#include "sim/truth.hpp"
#include "tools/study/estimator_trial.hpp"
#include "tools/study/simulated_drive.hpp"
#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
using Complex = std::complex<double>;

constexpr double kRamp_s = 6.0, kSettling_s = 4.0;
constexpr std::array kUnbalanceAngle_deg{217, 60, 305, 128}, kForceAngle_deg{30, 250, 110, 340};

std::string scenario_of(const ChainDrive& drive) {
  std::string text = "[drive]\nramp_s = " + std::to_string(kRamp_s) + "\n";
  for (const double speed_km_h : drive.speeds_km_h)
    text += "[[drive.plateau]]\nspeed_km_h = " + std::to_string(speed_km_h) +
            "\nseconds = " + std::to_string(drive.seconds + kRamp_s + kSettling_s) + "\n";
  text += "[road]\nclass = \"" + drive.road_class +
          "\"\nrear_coherence2 = " + std::to_string(drive.rear_coherence2) + "\n";
  const auto at_wheel = [&](const char* what, std::size_t w, const char* key, double value, int angle_deg) {
    if (value > 0.0)
      text += std::string("[[") + what + "]]\nwheel = \"" + kWheelNames[w] + "\"\n" + key + " = " +
              std::to_string(value) + "\nangle_deg = " + std::to_string(angle_deg) + "\n";
  };
  for (std::size_t w = 0; w < kWheels; ++w) {
    at_wheel("unbalance", w, "mass_g", drive.unbalance_g[w], kUnbalanceAngle_deg[w]);
    at_wheel("radial_force", w, "force_n", drive.radial_force_n[w], kForceAngle_deg[w]);
  }
  return text;
}

/// Remaining unbalance, in truth, after all steps of the product's plan.
double after_weights(const Balance& balance, Complex truth_g, const VehicleConfig& vehicle) {
  const WheelConfig& wheel = vehicle.wheel[static_cast<std::size_t>(balance.wheel)];
  const WeightPlan plan = compensate(balance, wheel, vehicle.limits).plan;
  return std::abs(plan.residual_g_m(truth_g * wheel.weight_radius_m)) / wheel.weight_radius_m;
}

Json force_of(const Balance& balance, Complex truth_g, double force_n, int force_deg) {
  const Complex force = std::polar(balance.force_n, balance.force_angle_rad);
  const bool apart = balance.force_state == ForceState::kSeparated;
  const auto only = [&](double value) { return apart ? number_or_null(value) : Json(nullptr); };
  return {
      {"force_state", static_cast<int>(balance.force_state)},
      {"alone_residual_g", only(std::abs(std::polar(balance.alone_g, balance.alone_angle_rad) - truth_g))},
      {"sigma_alone_g", only(balance.sigma_alone_g)},
      {"force_error_n", only(std::abs(force - std::polar(force_n, force_deg * kDegree)))},
      {"sigma_force_n", only(balance.sigma_force_n)}};
}

}  // namespace

std::array<WheelBound, kWheels> chain_bound(const ChainDrive& drive) {
  const VehicleConfig vehicle = demo_vehicle();
  const sim::Scenario scenario = sim::Scenario::parse(scenario_of(drive), "chain drive", vehicle);
  BoundQuestion question{.geometry = geometry_of(vehicle.model),
                         .parameters = nominal_parameters(vehicle),
                         .seconds = drive.seconds,
                         .exponent_free = true};
  question.road = {.roughness_m3 = scenario.road.roughness_m3,
                   .left_right_correlation = scenario.road.left_right_correlation,
                   .rear_coherence2 = scenario.road.rear_coherence2,
                   .rear_own_correlation = scenario.road.left_right_correlation};
  for (const double speed_km_h : drive.speeds_km_h) question.speeds_m_s.push_back(speed_km_h / 3.6);
  for (std::size_t w = 0; w < kWheels; ++w) {
    question.unbalance_kg_m[w] = scenario.wheel[w].unbalance_kg_m;
    question.asked.set(kEstimatedTyre + w)
        .set(kEstimatedUnbalance + 2 * w)
        .set(kEstimatedUnbalance + 2 * w + 1);
  }
  const UnknownMatrix least = cramer_rao(question);
  std::array<WheelBound, kWheels> bounds;
  for (std::size_t w = 0; w < kWheels; ++w) bounds[w] = wheel_bound(least, question, static_cast<int>(w));
  return bounds;
}

Json chain_errors(const ChainDrive& drive, std::uint64_t seed, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / ("chain-" + std::to_string(seed) + ".toml");
  std::ofstream(file) << scenario_of(drive);  // one that is not written is not found
  const VehicleConfig vehicle = demo_vehicle();
  const DriveEstimate estimate =
      identify_simulated_drive(vehicle, file.string() + "?seed=" + std::to_string(seed) + "&rate=max");
  const sim::Truth truth = sim::truth_of(file.string(), seed, vehicle);
  Json wheels = Json::array();
  for (std::size_t w = 0; w < kWheels; ++w) {
    const Balance& balance = estimate.balance[w];
    const Complex x = std::polar(balance.unbalance_g, balance.angle_rad);
    const Complex x0 = std::polar(truth.wheel[w].unbalance_g, truth.wheel[w].angle_deg * kDegree);
    const Eigen::Vector2d off((x - x0).real(), (x - x0).imag());
    const bool told = balance.state == Unknown::kNone;
    const bool pressed = estimate.identification.state == Unknown::kNone;
    const auto only = [](bool known, double value) { return known ? number_or_null(value) : Json(nullptr); };
    Json wheel{
        {"name", kWheelNames[w]},
        {"told", told},
        {"mass_percent", only(told, 100.0 * (std::abs(x / x0) - 1.0))},
        {"angle_deg", only(told, std::arg(x / x0) / kDegree)},
        {"residual_g", only(told, std::abs(x - x0))},
        {"rounded_g", after_weights(balance, x0, vehicle)},
        {"tyre_percent",
         only(pressed,
              100.0 * (estimate.identification.tyre_n_m[w] / truth.wheel[w].tyre_stiffness_n_m - 1.0))},
        {"ellipse", only(told, off.dot(balance.covariance_g2.inverse() * off))}};
    wheel.update(force_of(balance, x0, drive.radial_force_n[w], kForceAngle_deg[w]));
    wheels.push_back(wheel);
  }
  return wheels;
}

std::vector<double> chain_values(const std::vector<Json>& runs, const std::string& key, int wheel,
                                 const char* what) {
  std::vector<double> values;
  for (const Json& run : runs)
    for (int w = 0; w < kWheels; ++w) {
      if (wheel >= 0 && w != wheel) continue;
      const Json& value = run[key][static_cast<std::size_t>(w)][what];
      values.push_back(value.is_number() ? value.get<double>() : std::nan(""));
    }
  return values;
}

}  // namespace roadbalance
