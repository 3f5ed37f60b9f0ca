#include "sim/scenario.hpp"

#include <algorithm>
#include <limits>

#include "common/config/section.hpp"
#include "common/types/angle_units.hpp"
#include "embedded/demo_scenario.hpp"

namespace roadbalance::sim {
namespace {

constexpr double kKmH = 1.0 / 3.6, kFastest_km_h = 300.0;

DriveScenario parse_drive(Section section) {
  DriveScenario drive;
  drive.ramp_s = section.number_or("ramp_s", {0.5, 60.0}, 6.0);
  drive.wander_m_s = section.number_or("wander_km_h", {0.0, 5.0}, 0.5) * kKmH;
  drive.drift_m_s2 = section.number_or("drift_km_h_min", {0.0, 60.0}, 0.0) * kKmH / 60.0;
  double fastest_m_s = 0.0, end_s = 0.0;
  for (Section& plateau : section.sections("plateau", 1)) {
    const double speed_m_s = plateau.number("speed_km_h", {0.0, kFastest_km_h}) * kKmH;
    if (drive.wander_m_s > 0.0 && speed_m_s < 4.0 * drive.wander_m_s)
      plateau.fail("speed_km_h", "must be at least four times wander_km_h, the car never reverses");
    drive.plateau.push_back({speed_m_s, plateau.number("seconds", {1.0, 1e6})});
    plateau.finish();
    fastest_m_s = std::max(fastest_m_s, speed_m_s);
    end_s += drive.plateau.back().seconds;
  }
  if (fastest_m_s + drive.drift_m_s2 * end_s > kFastest_km_h * kKmH)
    section.fail("drift_km_h_min", "must not make the car faster than 300 km/h");
  section.finish();
  return drive;
}

RoadScenario parse_road(Section section) {
  static const std::vector<std::string> kClasses{"A", "B", "C", "S", "none"};
  static constexpr std::array<double, 5> kRoughness{16e-6, 64e-6, 256e-6, 4e-6, 0.0};
  RoadScenario road{};
  road.roughness_m3 = kRoughness[section.choice_or("class", kClasses, 0)];
  road.left_right_correlation = section.number_or("left_right_correlation", {-1.0, 1.0}, 0.3);
  road.rear_coherence2 = section.number_or("rear_coherence2", {0.0, 1.0}, 0.95);
  section.finish();
  return road;
}

std::size_t parse_wheel(Section& section) {
  return section.choice("wheel", {kWheelNames.begin(), kWheelNames.end()});
}

SensorScenario parse_sensor(Section section) {
  SensorScenario sensor{};
  sensor.noise_m_s2 = section.number_or("noise_m_s2", {0.0, 100.0}, 0.02);
  sensor.coupling_from_vertical = section.number_or("coupling_from_vertical", {-0.2, 0.2}, 0.02);
  sensor.coupling_into_vertical = section.number_or("coupling_into_vertical", {-0.2, 0.2}, 0.003);
  section.finish();
  return sensor;
}

EncoderScenario parse_encoder(Section section) {
  EncoderScenario encoder{};
  // 0.14 rms keeps the teeth in order: no error is beyond 3.47 rms, and 2 * 3.47 * 0.14 < 1.
  encoder.pitch_error_pitches = section.number_or("pitch_error_pitches", {0.0, 0.14}, 0.08);
  encoder.eccentricity_rad = section.number_or("eccentricity_deg", {0.0, 2.0}, 0.0) * kDegree;
  encoder.tooth_offset_pitches = section.number_or("tooth_offset_pitches", {0.0, 1.0}, 0.0);
  encoder.stamp_jitter_s = section.number_or("stamp_jitter_us", {0.0, 250.0}, 5.0) * 1e-6;
  section.finish();
  return encoder;
}

DamperScenario parse_damper(Section section) {
  DamperScenario damper;
  damper.compression = section.number_or("compression", {0.0, 3.0}, damper.compression);
  damper.rebound = section.number_or("rebound", {0.0, 3.0}, damper.rebound);
  damper.knee_m_s = section.number_or("knee_m_s", {0.0, 10.0}, damper.knee_m_s);
  damper.friction_n = section.number_or("friction_n", {0.0, 300.0}, damper.friction_n);
  section.finish();
  return damper;
}

/// An absent table means its defaults.
Section table_or_empty(Section& root, const std::string& key) {
  auto table = root.section_if(key);
  return table ? std::move(*table) : Section::parse_text("", key);
}

}  // namespace

double Scenario::seconds() const {
  double sum = 0.0;
  for (const Plateau& plateau : drive.plateau) sum += plateau.seconds;
  return sum;
}

void Scenario::scale_to(double seconds_wanted) {
  const double factor = seconds_wanted / seconds();
  for (Plateau& plateau : drive.plateau) plateau.seconds *= factor;
  drive.drift_m_s2 /= factor;
}

namespace {

Scenario parse_root(Section root, const VehicleConfig& vehicle) {
  Scenario scenario{};
  scenario.seed =
      static_cast<std::uint64_t>(root.integer_or("seed", 0, std::numeric_limits<std::int64_t>::max(), 1));
  scenario.drive = parse_drive(root.section("drive"));
  scenario.road = parse_road(table_or_empty(root, "road"));
  for (Section& entry : root.sections("unbalance")) {
    const std::size_t wheel = parse_wheel(entry);
    const double mass_kg = entry.number("mass_g", {0.0, 10e3}) * 1e-3;
    const double radius_m = entry.number_or("radius_m", {0.01, 1.0}, vehicle.wheel[wheel].weight_radius_m);
    const double angle_rad = entry.number("angle_deg", {-360.0, 360.0}) * kDegree;
    scenario.wheel[wheel].unbalance_kg_m += std::polar(mass_kg * radius_m, angle_rad);
    entry.finish();
  }
  for (Section& entry : root.sections("radial_force")) {
    const std::size_t wheel = parse_wheel(entry);
    const double force_n = entry.number("force_n", {0.0, 10e3});
    scenario.wheel[wheel].radial_force_n +=
        std::polar(force_n, entry.number("angle_deg", {-360.0, 360.0}) * kDegree);
    entry.finish();
  }
  Section spread = table_or_empty(root, "spread");
  scenario.parameter_spread = spread.number_or("parameters", {0.0, 0.5}, 0.10);
  scenario.rolling_radius_spread = spread.number_or("rolling_radius", {0.0, 0.05}, 0.003);
  spread.finish();
  scenario.sensor = parse_sensor(table_or_empty(root, "sensor"));
  scenario.encoder = parse_encoder(table_or_empty(root, "encoder"));
  scenario.damper = parse_damper(table_or_empty(root, "damper"));
  root.finish();
  return scenario;
}

}  // namespace

Scenario Scenario::parse(const std::string& text, const std::string& name_for_errors,
                         const VehicleConfig& vehicle) {
  return parse_root(Section::parse_text(text, name_for_errors), vehicle);
}

Scenario Scenario::read(const std::string& path, const VehicleConfig& vehicle) {
  if (path.empty()) return parse(std::string(embedded::kDemoScenario), "demo scenario", vehicle);
  return parse_root(Section::parse_file(path), vehicle);
}

}  // namespace roadbalance::sim
