#include "tools/study/real_drive.hpp"

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <optional>
#include <ranges>

#include "common/types/angle_units.hpp"
#include "host/analysis/identify/drive_estimator.hpp"
#include "sim/truth.hpp"
#include "tools/study/estimator_trial.hpp"
#include "tools/study/simulated_drive.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
using Complex = std::complex<double>;

/// Of a wheel's results.
constexpr std::array kKeys{"mass_percent",  "angle_deg",     "residual_g",    "sigma_percent",
                           "sigma_deg",     "ellipse",       "alone_ellipse", "force_error_n",
                           "sigma_force_n", "force_ellipse", "tyre_percent"};
constexpr double kChange_s = 10.0;  ///< to a speed, and until the car has settled

std::string scenario_of(const RealDrive& drive) {
  const Hazard& hazard = drive.hazard;
  std::string text = "[drive]\nramp_s = 6.0\n";
  for (const double speed_km_h : drive.speeds_km_h)
    text += "[[drive.plateau]]\nspeed_km_h = " + std::to_string(speed_km_h) +
            "\nseconds = " + std::to_string(drive.seconds + kChange_s) + "\n";
  text += "[road]\nclass = \"" + drive.road_class + "\"\n" + hazard.road;
  const auto table = [&text](const char* name, const std::string& lines) {
    if (!lines.empty()) text += std::string("[") + name + "]\n" + lines;
  };
  table("tyre", hazard.tyre);
  table("damper", hazard.damper);
  table("spread", "parameters = 0.10\nrolling_radius = 0.003\n" + hazard.spread);
  table("sensor",
        "noise_m_s2 = 0.02\ncoupling_from_vertical = 0.02\ncoupling_into_vertical = 0.003\n" + hazard.sensor);
  constexpr std::array kMass_g{35, 20, 12, 14}, kAngle_deg{217, 60, 305, 128};
  for (std::size_t w = 0; w < kWheels; ++w)
    text += std::string("[[unbalance]]\nwheel = \"") + kWheelNames[w] +
            "\"\nmass_g = " + std::to_string(kMass_g[w]) + "\nangle_deg = " + std::to_string(kAngle_deg[w]) +
            "\n";
  if (hazard.radial_force_n > 0.0)
    text += "[[radial_force]]\nwheel = \"front_left\"\nforce_n = " + std::to_string(hazard.radial_force_n) +
            "\nangle_deg = 100\n";
  return text;
}

/// (x - truth)' C^-1 (x - truth)
double ellipse(Complex difference, const Eigen::Matrix2d& covariance) {
  const Eigen::Vector2d parts(difference.real(), difference.imag());
  return parts.dot(covariance.inverse() * parts);
}

/// Part of a force that does not grow with speed in the best correction, 1 / (rad/s)^2: as long is driven at
/// each speed.
double share_of_force(const RealDrive& drive, double rolling_radius_m) {
  double square = 0.0, fourth = 0.0;
  for (const double speed_km_h : drive.speeds_km_h) {
    const double omega = speed_km_h / 3.6 / rolling_radius_m;
    square += omega * omega;
    fourth += std::pow(omega, 4);
  }
  return square / fourth;
}

}  // namespace

VehicleConfig car_of_a_stranger() {
  VehicleConfig vehicle = demo_vehicle();
  vehicle.model.body_mass_sigma_kg = 0.03 * vehicle.model.body_mass_kg;
  vehicle.model.roll_inertia_sigma_kg_m2 = 0.1 * vehicle.model.roll_inertia_kg_m2;
  vehicle.model.pitch_inertia_sigma_kg_m2 = 0.1 * vehicle.model.pitch_inertia_kg_m2;
  for (AxleConfig& axle : vehicle.model.axle) axle.tyre_damper_sigma_n_s_m = 50.0;
  for (WheelConfig& wheel : vehicle.wheel) wheel.mass_sigma_kg = 0.02 * wheel.mass_kg;
  for (NodeConfig& node : vehicle.node)
    for (ChannelConfig& channel : node.channel) channel.gain_sigma = 0.01;
  return vehicle;
}

std::span<const Hazard> hazards() {
  static const std::vector<Hazard> kAll{
      {.name = "none"},
      {.name = "waviness 1.5", .road = "waviness = 1.5\n"},
      {.name = "waviness 1.7", .road = "waviness = 1.7\n"},
      {.name = "waviness 2.3", .road = "waviness = 2.3\n"},
      {.name = "waviness 2.5", .road = "waviness = 2.5\n"},
      {.name = "waviness 3.0", .road = "waviness = 3.0\n"},
      {.name = "bent at 0.1", .road = "waviness = 1.5\nwaviness_above = 3.0\nbend_1_m = 0.1\n"},
      {.name = "bent at 0.4", .road = "waviness = 1.5\nwaviness_above = 3.0\nbend_1_m = 0.4\n"},
      {.name = "1.6 left, 2.6 right", .road = "waviness = 1.6\nright_waviness = 1.0\n"},
      {.name = "wanders", .road = "stretch_waviness = 0.3\nstretch_height = 2.0\n"},
      {.name = "potholes of 70 m/s2", .road = "potholes_per_km = 1.6\npothole_mm = [15, 15]\n"},
      {.name = "potholes of 220 m/s2", .road = "potholes_per_km = 1.6\npothole_mm = [46, 46]\n"},
      {.name = "friction 50 N", .damper = "friction_n = 50.0\n"},
      {.name = "friction 100 N", .damper = "friction_n = 100.0\n"},
      {.name = "dampers 1 : 3", .damper = "rebound_ratio = 3.0\n"},
      {.name = "masses, inertias", .spread = "sigmas = 1.0\n"},
      {.name = "tyre drift 5 %, 20 N", .tyre = "warming = 0.05\nradial_force_1_n = [20, 20]\n"},
      {.name = "forces to 60 N",
       .tyre = "radial_force_1_n = [0, 60]\nradial_force_2_n = [0, 60]\nradial_force_3_n = [0, 60]\n"},
      {.name = "50 N front left", .radial_force_n = 50.0},
      {.name = "gains 1.7 %", .sensor = "gain = 0.03\n"},
      {.name = "tilts to 2 deg", .sensor = "tilt_deg = 2.0\n"},
      {.name = "brackets", .sensor = "bracket_hz = [80, 250]\n"},
      {.name = "filter 3 %", .sensor = "filter = 0.03\n"},
      {.name = "mounting noise", .sensor = "mounting_noise_m_s2 = [0.05, 0.2]\n"}};
  return kAll;
}

const Hazard& real_road() {
  static const Hazard kAll{
      .name = "all",
      .road =
          "waviness = [1.5, 3.3]\nright_waviness = [-0.3, 0.3]\nstretch_waviness = 0.2\n"
          "stretch_height = 1.5\nrear_coherence2 = [0.5, 0.98]\njoints_per_km = [0, 2]\n"
          "joint_mm = [2, 10]\npotholes_per_km = [0, 2]\npothole_mm = [6, 52]\n",
      .tyre =
          "radial_force_1_n = [0, 60]\nradial_force_2_n = [0, 60]\nradial_force_3_n = [0, 60]\n"
          "warming = [0, 0.05]\n",
      .damper = "rebound_ratio = [1, 3]\nfriction_n = [0, 100]\n",
      .spread = "sigmas = 1.0\nforward_hz = [15, 30]\n",
      .sensor =
          "tilt_deg = 1.0\ngain = 0.03\nbracket_hz = [80, 250]\nmounting_noise_m_s2 = [0, 0.1]\n"
          "filter = 0.03\n",
      .gain_sigma = 0.03 / std::numbers::sqrt3};
  return kAll;
}

Json real_drive_errors(const RealDrive& drive, std::uint64_t seed, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / ("real-" + std::to_string(seed) + ".toml");
  std::ofstream(file) << scenario_of(drive);  // one that is not written is not found
  VehicleConfig vehicle = car_of_a_stranger();
  for (NodeConfig& node : vehicle.node)
    for (ChannelConfig& channel : node.channel) channel.gain_sigma = drive.hazard.gain_sigma;
  DriveEstimator estimator(vehicle);
  simulate_drive(vehicle, file.string() + "?seed=" + std::to_string(seed) + "&rate=max", {},
                 [&](const SealedBlock& block) { estimator.consume(block); });
  estimator.estimate();
  const std::optional<PosteriorCar>& car = estimator.car();
  const bool told = car && estimator.refusal().empty();
  const sim::DrawnCar truth = sim::truth_of(file.string(), seed, vehicle).car;
  Json wheels = Json::array();
  for (std::size_t w = 0; w < kWheels; ++w) {
    Json wheel{{"name", kWheelNames[w]}};
    if (!told) {
      for (const char* key : kKeys) wheel[key] = nullptr;
      wheels.push_back(wheel);
      continue;
    }
    const auto put = [&](const char* key, double value) { wheel[key] = number_or_null(value); };
    const WheelFirstOrder& found = car->wheel[w];
    const auto i = static_cast<Eigen::Index>(w);
    const Complex force = truth.wheel[w].radial_force_n;
    const Complex unbalance = truth.wheel[w].unbalance_kg_m;
    const Complex correction = unbalance + force * share_of_force(drive, vehicle.wheel[w].rolling_radius_m);
    const Complex unit = correction / std::abs(correction);
    const Eigen::Vector2d along(unit.real(), unit.imag()), across(-unit.imag(), unit.real());
    const auto sigma = [&](const Eigen::Vector2d& way) {
      return std::sqrt(way.dot(found.correction_covariance * way)) / std::abs(correction);
    };
    put("mass_percent", 100.0 * (std::abs(found.correction_kg_m) / std::abs(correction) - 1.0));
    put("angle_deg", std::arg(found.correction_kg_m / correction) * kDegrees);
    put("residual_g", 1e3 * std::abs(found.correction_kg_m - correction) / vehicle.wheel[w].weight_radius_m);
    put("sigma_percent", 100.0 * sigma(along));
    put("sigma_deg", sigma(across) * kDegrees);
    put("ellipse", ellipse(found.correction_kg_m - correction, found.correction_covariance));
    put("alone_ellipse", ellipse(found.unbalance_kg_m - unbalance, found.unbalance_covariance));
    put("force_error_n", std::abs(found.force_n - force));
    put("sigma_force_n", std::sqrt(0.5 * found.force_covariance.trace()));
    put("force_ellipse", ellipse(found.force_n - force, found.force_covariance));
    const Eigen::Index tyre = kTyre + i;
    put("tyre_percent", 100.0 * (car->parameters(tyre) / truth.parameters(tyre) - 1.0));
    wheels.push_back(wheel);
  }
  if (const std::string refusal = estimator.refusal(); !refusal.empty())
    std::fprintf(stderr, "%s, drive %llu: %s\n", drive.hazard.name.c_str(),
                 static_cast<unsigned long long>(seed), refusal.c_str());
  // The first of an estimate is on its scale.
  for (const std::string& remark : estimator.remarks() | std::views::drop(told ? 1 : 0))
    std::fprintf(stderr, "%s, drive %llu: %s\n", drive.hazard.name.c_str(),
                 static_cast<unsigned long long>(seed), remark.c_str());
  return wheels;
}

}  // namespace roadbalance
