#include "tools/study/many_drives.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "common/vehicle/sensor_map.hpp"
#include "host/analysis/identify/estimate.hpp"
#include "host/analysis/identify/joint_drives.hpp"
#include "host/analysis/identify/section.hpp"
#include "sim/random.hpp"
#include "tools/study/estimator_trial.hpp"
#include "tools/study/ideal_drive.hpp"
#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;
using Complex = std::complex<double>;
using sim::RandomSequence;
using sim::Use;

constexpr double kSpread = 0.1, kSensorNoise_m_s2 = 0.02, kRate_hz = 500.0;
constexpr double kSlowest_km_h = 80.0, kFastest_km_h = 130.0, kLeastApart_km_h = 8.0;
constexpr std::array kMass_g{30.0, 20.0, 25.0, 15.0}, kDrivesAngle_deg{217.0, 60.0, 305.0, 128.0};
constexpr std::array kRoughness_m3{16e-6, 64e-6, 16e-6, 256e-6};  // ISO 8608: A, B, A, C

Complex mean_unbalance_g(std::size_t wheel) {
  return std::polar(kMass_g[wheel], kDrivesAngle_deg[wheel] * std::numbers::pi / 180.0);
}

VehicleConfig draw_one(VehicleConfig car, std::uint64_t seed) {
  const RandomSequence random(seed, Use::kParameters, 0);
  std::int64_t counter = 0;
  for (AxleConfig& axle : car.model.axle)
    for (double* value : {&axle.spring_n_m, &axle.damper_n_s_m, &axle.stabiliser_n_m, &axle.tyre_n_m})
      *value *= 1.0 + kSpread * (2.0 * random.uniform(counter++) - 1.0);
  return car;
}

/// The car as identification assumes it; its sensors are as true as they are.
VehicleConfig described_car() {
  VehicleConfig car = demo_vehicle();
  for (NodeConfig& node : car.node)
    for (ChannelConfig& channel : node.channel) channel.gain_sigma = 0.0;
  return car;
}

std::vector<Stretch> drive_once(const ManyDrives& drives, VehicleConfig car, std::uint64_t seed, int drive) {
  const RandomSequence random(seed, Use::kParameters, static_cast<std::uint64_t>(1 + drive));
  const double warmth = 1.0 + 0.01 * drives.tyre_percent * random.normal(0);
  for (AxleConfig& axle : car.model.axle) axle.tyre_n_m *= warmth;
  IdealDrive one{.scenario = sim::Scenario::read("", car),
                 .speeds_m_s = {},
                 .samples = static_cast<Eigen::Index>(drives.seconds * kRate_hz),
                 .rate_hz = kRate_hz};
  one.scenario.parameter_spread = 0.0;
  one.scenario.road.roughness_m3 = kRoughness_m3[static_cast<std::size_t>(drive) % kRoughness_m3.size()];
  for (std::size_t w = 0; w < kWheels; ++w) {
    const auto at = static_cast<std::int64_t>(10 + 2 * w);
    const Complex differs(random.normal(at), random.normal(at + 1));
    one.scenario.wheel[w].unbalance_kg_m =
        1e-3 * car.wheel[w].weight_radius_m * (mean_unbalance_g(w) + drives.unbalance_g * differs);
    one.scenario.wheel[w].radial_force_n = 0.0;
  }
  const double slow = kSlowest_km_h + (kFastest_km_h - kLeastApart_km_h - kSlowest_km_h) * random.uniform(1);
  const double fast = slow + kLeastApart_km_h + (kFastest_km_h - kLeastApart_km_h - slow) * random.uniform(2);
  one.speeds_m_s = {slow / 3.6, fast / 3.6};
  auto stretches = drive_ideally(one, random.bits(3), car);
  for (std::size_t s = 0; s < stretches.size(); ++s)
    for (int row = 0; row < kCoordinates; ++row) {
      const RandomSequence noise(random.bits(4), Use::kSensorNoise,
                                 100 * s + static_cast<std::uint64_t>(row));
      for (Eigen::Index k = 0; k < stretches[s].signals.cols(); ++k)
        stretches[s].signals(row, k) += kSensorNoise_m_s2 * noise.normal(k);
    }
  return stretches;
}

/// Contribution of the drive to the joint estimate, weighed by its information on the car (DriveEstimator).
DriveSums sums_of(const std::vector<Stretch>& stretches, const VehicleConfig& described) {
  std::vector<DrivenSection> driven;
  const Eigen::MatrixXd sensors = SensorMap::from(described).readings;
  SectionBuilder sections(
      described, [&](const DrivenSection& section) { driven.push_back(section); }, sensors);
  for (const Stretch& stretch : stretches)
    for (Eigen::Index k = 0; k < stretch.signals.cols(); ++k)
      sections.consume({.signals = stretch.signals.col(k),
                        .readings = sensors * stretch.signals.col(k).head<kCoordinates>(),
                        .restart = k == 0});
  DriveMoments total;
  for (const DrivenSection& section : driven) total += section;
  const Priors known = Priors::of(described);
  if (const auto x = solve(total, known.geometry, known.value)) {
    ParameterVector weights = known.value;
    weights.segment<kEstimatedUnbalance>(kSpring) = x->head<kEstimatedUnbalance>();
    sections.set_parameters(weights);
    for (DrivenSection& section : driven) sections.weigh_anew(section);
  }
  DriveSums sums(described.drive.speed_class_m_s);
  for (const DrivenSection& section : driven) {
    sums.classes.add(section);
    sums.posterior.add(section, described.drive.speed_class_m_s);
  }
  sums.drift = sections.phase_drift();
  sums.state = driven.empty() ? Unknown::kTooShort : Unknown::kNone;
  return sums;
}

Json wheel_of(const DriveEstimate& estimate, double ratio, const VehicleConfig& truth, std::size_t w) {
  const Balance& balance = estimate.balance[w];
  const Identification& all = estimate.identification;
  const bool told = balance.state == Unknown::kNone && all.state == Unknown::kNone;
  if (!told)
    return {{"off_g", {nullptr, nullptr}}, {"ellipse", nullptr},     {"sigma_g", nullptr},
            {"tyre_percent", nullptr},     {"tyre_sigmas", nullptr}, {"ratio", nullptr}};
  const Complex mean = mean_unbalance_g(w);
  const Complex off = std::polar(balance.unbalance_g, balance.angle_rad) - mean;
  const Complex turned = off * std::conj(mean) / std::abs(mean);
  const Eigen::Vector2d e(off.real(), off.imag());
  const double tyre = truth.model.axle[w / 2].tyre_n_m;
  return {{"off_g", {turned.real(), turned.imag()}},
          {"ellipse", number_or_null(e.dot(balance.covariance_g2.inverse() * e))},
          {"sigma_g", number_or_null(std::sqrt(0.5 * balance.covariance_g2.trace()))},
          {"tyre_percent", number_or_null(100.0 * (all.tyre_n_m[w] / tyre - 1.0))},
          {"tyre_sigmas", number_or_null((all.tyre_n_m[w] - tyre) / all.sigma_tyre_n_m[w])},
          {"ratio", number_or_null(ratio)}};
}

Joining joining_of(Joined joined) {
  return {.by_road = joined != Joined::kPlainSums, .widened = joined == Joined::kProduct};
}

}  // namespace

std::vector<int> joined_sizes(int drives) {
  return {drives / 4, drives / 2, drives};
}

std::string joined_key(Joined joined, int drives) {
  const char* const name = joined == Joined::kProduct      ? "as the product does"
                           : joined == Joined::kNotWidened ? "not widened"
                                                           : "plain sums";
  return std::to_string(drives) + " drives, " + name;
}

Json many_drives_run(const ManyDrives& drives, std::uint64_t seed) {
  const VehicleConfig described = described_car(), car = draw_one(described, seed);
  std::vector<JointDrives> joint;
  for (const Joined joined : kJoined) joint.emplace_back(described, joining_of(joined));
  const std::vector<int> sizes = joined_sizes(drives.drives);
  Json result = Json::object();
  for (int drive = 0; drive < drives.drives; ++drive) {
    const DriveSums sums = sums_of(drive_once(drives, car, seed, drive), described);
    for (JointDrives& each : joint) each.add(sums);
    if (std::find(sizes.begin(), sizes.end(), drive + 1) == sizes.end()) continue;
    for (std::size_t j = 0; j < joint.size(); ++j) {
      Json wheels = Json::array();
      const DriveEstimate& estimate = joint[j].estimate();
      for (std::size_t w = 0; w < kWheels; ++w)
        wheels.push_back(wheel_of(estimate, joint[j].drives_ratio()[w], car, w));
      result[joined_key(kJoined[j], drive + 1)] = wheels;
    }
  }
  return result;
}

}  // namespace roadbalance
