#include "sim/scenario.hpp"

#include <algorithm>
#include <limits>

#include "common/config/section.hpp"
#include "common/types/angle_units.hpp"
#include "embedded/demo_scenario.hpp"
#include "sim/random.hpp"

namespace roadbalance::sim {
namespace {

constexpr double kKmH = 1.0 / 3.6, kFastest_km_h = 300.0;

/// Values of keys that are given by bounds, drawn by a seed: each key has a sequence of its own.
class Drawn {
 public:
  explicit Drawn(std::uint64_t seed) : seed_(seed) {}
  double operator()(Section& section, const std::string& key, Range range, double otherwise) const {
    const Range bounds = section.bounds_or(key, range, {otherwise, otherwise});
    return RandomSequence(seed_, Use::kScenario, hash(key)).between(0, bounds.low, bounds.high);
  }

 private:
  /// FNV-1a, which is the same everywhere.
  static std::uint64_t hash(const std::string& key) {
    std::uint64_t value = 0xcbf29ce484222325ULL;
    for (const char c : key) value = (value ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    return value;
  }
  std::uint64_t seed_;
};

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

ObstacleScenario parse_obstacle(Section& section, const std::string& name, const Drawn& drawn) {
  ObstacleScenario obstacle;
  obstacle.per_km = drawn(section, name + "s_per_km", {0.0, 100.0}, obstacle.per_km);
  Range mm = section.bounds_or(name + "_mm", {0.0, 200.0}, {0.0, 0.0});
  obstacle.height_m = {1e-3 * mm.low, 1e-3 * mm.high};
  return obstacle;
}

RoadScenario parse_road(Section section, const Drawn& drawn) {
  static const std::vector<std::string> kClasses{"A", "B", "C", "S", "none"};
  static constexpr std::array<double, 5> kRoughness{16e-6, 64e-6, 256e-6, 4e-6, 0.0};
  constexpr Range kWaviness{1.0, 4.0};
  RoadScenario road{};
  road.roughness_m3 = kRoughness[section.choice_or("class", kClasses, 0)];
  road.left_right_correlation = section.number_or("left_right_correlation", {-1.0, 1.0}, 0.3);
  road.rear_coherence2 = drawn(section, "rear_coherence2", {0.0, 1.0}, 0.95);
  road.waviness.below = drawn(section, "waviness", kWaviness, road.waviness.below);
  road.waviness.bend_1_m = drawn(section, "bend_1_m", {0.0, 10.0}, road.waviness.bend_1_m);
  road.waviness.above = drawn(section, "waviness_above", kWaviness, road.waviness.below);
  road.right_waviness = drawn(section, "right_waviness", {-2.0, 2.0}, road.right_waviness);
  road.stretch_m = section.number_or("stretch_m", {10.0, 1e5}, road.stretch_m);
  road.stretch_waviness = section.number_or("stretch_waviness", {0.0, 0.5}, road.stretch_waviness);
  road.stretch_height = section.number_or("stretch_height", {1.0, 4.0}, road.stretch_height);
  road.joint = parse_obstacle(section, "joint", drawn);
  road.pothole = parse_obstacle(section, "pothole", drawn);
  section.finish();
  return road;
}

TyreScenario parse_tyre(Section section, const Drawn& drawn) {
  TyreScenario tyre;
  for (std::size_t k = 0; k < tyre.radial_force_n.size(); ++k)
    tyre.radial_force_n[k] =
        section.bounds_or("radial_force_" + std::to_string(k + 1) + "_n", {0.0, 10e3}, {0.0, 0.0});
  tyre.warming = drawn(section, "warming", {0.0, 0.3}, tyre.warming);
  tyre.warming_s = section.number_or("warming_s", {1.0, 1e4}, tyre.warming_s);
  section.finish();
  return tyre;
}

std::size_t parse_wheel(Section& section) {
  return section.choice("wheel", {kWheelNames.begin(), kWheelNames.end()});
}

SensorScenario parse_sensor(Section section, const Drawn& drawn) {
  SensorScenario sensor{};
  sensor.noise_m_s2 = section.number_or("noise_m_s2", {0.0, 100.0}, 0.02);
  sensor.coupling_from_vertical = section.number_or("coupling_from_vertical", {-0.2, 0.2}, 0.02);
  sensor.coupling_into_vertical = section.number_or("coupling_into_vertical", {-0.2, 0.2}, 0.003);
  sensor.tilt_rad = section.number_or("tilt_deg", {0.0, 30.0}, 0.0) * kDegree;
  sensor.gain = section.number_or("gain", {0.0, 0.5}, sensor.gain);
  sensor.bracket_hz = section.bounds_or("bracket_hz", {0.0, 1e4}, sensor.bracket_hz);
  sensor.bracket_damping = section.number_or("bracket_damping", {1e-3, 1.0}, sensor.bracket_damping);
  sensor.mounting_noise_m_s2 =
      section.bounds_or("mounting_noise_m_s2", {0.0, 100.0}, sensor.mounting_noise_m_s2);
  sensor.clips_at = drawn(section, "clips_at", {1e-3, 1.0}, sensor.clips_at);
  sensor.filter = section.number_or("filter", {0.0, 0.2}, sensor.filter);
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

DamperScenario parse_damper(Section section, const Drawn& drawn) {
  DamperScenario damper;
  // Of a ratio the mean stays.
  const double ratio = drawn(section, "rebound_ratio", {0.1, 10.0}, 1.0);
  damper.compression = section.number_or("compression", {0.0, 3.0}, 2.0 / (1.0 + ratio));
  damper.rebound = section.number_or("rebound", {0.0, 3.0}, 2.0 * ratio / (1.0 + ratio));
  damper.knee_m_s = section.number_or("knee_m_s", {0.0, 10.0}, damper.knee_m_s);
  damper.friction_n = drawn(section, "friction_n", {0.0, 300.0}, damper.friction_n);
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

Scenario parse_root(Section root, const VehicleConfig& vehicle, std::optional<std::uint64_t> seed) {
  Scenario scenario{};
  const auto own_seed = root.integer_or("seed", 0, std::numeric_limits<std::int64_t>::max(), 1);
  scenario.seed = seed.value_or(static_cast<std::uint64_t>(own_seed));
  const Drawn drawn(scenario.seed);
  scenario.drive = parse_drive(root.section("drive"));
  scenario.road = parse_road(table_or_empty(root, "road"), drawn);
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
    const auto order = static_cast<std::size_t>(entry.integer_or("order", 1, 3, 1));
    WheelScenario& of = scenario.wheel[wheel];
    (order == 1 ? of.radial_force_n : of.higher_radial_force_n[order - 2]) +=
        std::polar(force_n, entry.number("angle_deg", {-360.0, 360.0}) * kDegree);
    entry.finish();
  }
  Section spread = table_or_empty(root, "spread");
  scenario.parameter_spread = spread.number_or("parameters", {0.0, 0.5}, 0.10);
  scenario.rolling_radius_spread = spread.number_or("rolling_radius", {0.0, 0.05}, 0.003);
  scenario.sigma_spread = spread.number_or("sigmas", {0.0, 3.0}, scenario.sigma_spread);
  scenario.forward_hz = drawn(spread, "forward_hz", {5.0, 100.0}, scenario.forward_hz);
  spread.finish();
  scenario.tyre = parse_tyre(table_or_empty(root, "tyre"), drawn);
  scenario.sensor = parse_sensor(table_or_empty(root, "sensor"), drawn);
  scenario.encoder = parse_encoder(table_or_empty(root, "encoder"));
  scenario.damper = parse_damper(table_or_empty(root, "damper"), drawn);
  root.finish();
  return scenario;
}

}  // namespace

Scenario Scenario::parse(const std::string& text, const std::string& name_for_errors,
                         const VehicleConfig& vehicle, std::optional<std::uint64_t> seed) {
  return parse_root(Section::parse_text(text, name_for_errors), vehicle, seed);
}

Scenario Scenario::read(const std::string& path, const VehicleConfig& vehicle,
                        std::optional<std::uint64_t> seed) {
  if (path.empty()) return parse(std::string(embedded::kDemoScenario), "demo scenario", vehicle, seed);
  return parse_root(Section::parse_file(path), vehicle, seed);
}

}  // namespace roadbalance::sim
