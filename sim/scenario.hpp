#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"
#include "sim/damper.hpp"
#include "sim/waviness.hpp"

namespace roadbalance::sim {

/// A stretch of the drive at one speed.
struct Plateau {
  double speed_m_s;
  double seconds;  ///< the ramp from the previous speed included
};

struct DriveScenario {
  std::vector<Plateau> plateau;
  double ramp_s;            ///< length of a speed change, shortened to half a plateau if need be
  double wander_m_s;        ///< four slow sinusoids, together as strong as one of this amplitude
  double drift_m_s2 = 0.0;  ///< steadily faster from beginning to end, on top of all else
};

/// What stands out of a road, one in each stretch of 1 / per_km: raised cosines.
struct ObstacleScenario {
  double per_km = 0.0;
  Range height_m{0.0, 0.0};  ///< of each; a pothole's is downwards
};

struct RoadScenario {
  double roughness_m3;  ///< Gd(n0) of ISO 8608, n0 = 0.1 1/m; 0 is flat but for obstacles
  double left_right_correlation;
  double rear_coherence2;       ///< squared coherence of the road under a rear wheel with its front wheel's
  Waviness waviness{};          ///< of the left side
  double right_waviness = 0.0;  ///< by how much the exponents of the right side's own part are greater
  double stretch_m = 300.0;
  double stretch_waviness = 0.0;  ///< stretches differ by up to +- so much in the exponents
  double stretch_height = 1.0;    ///< and by up to this factor, and one by it, in height
  ObstacleScenario joint{};       ///< across both tracks
  ObstacleScenario pothole{};     ///< in each track others
};

/// Complex amplitudes by wheel, phase from the reference point in the direction of rotation (conventions.md).
struct WheelScenario {
  std::complex<double> unbalance_kg_m{};
  std::complex<double> radial_force_n{};  ///< of a tyre that is not uniform, first order
  std::array<std::complex<double>, 2> higher_radial_force_n{};  ///< orders 2 and 3
};

struct TyreScenario {
  /// Amplitudes of orders 1, 2, 3, for each wheel another, of any phase; beside those of WheelScenario.
  std::array<Range, 3> radial_force_n{{{0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}}};
  double warming = 0.0;      ///< part of its stiffness, and of its radial forces, that a cold tyre has more
  double warming_s = 300.0;  ///< time constant
};

/// Sensors, each with its own faults, and the node's analogue filter.
struct SensorScenario {
  double noise_m_s2;              ///< rms of what is converted
  double coupling_from_vertical;  ///< vertical acceleration seen by a horizontal sensor
  double coupling_into_vertical;  ///< each horizontal acceleration seen by a vertical sensor
  double tilt_rad = 0.0;          ///< at most
  double gain = 0.0;              ///< up to +- so much
  Range bracket_hz{0.0, 0.0};     ///< resonance of what it is mounted on; 0: there is none
  double bracket_damping = 0.05;
  Range mounting_noise_m_s2{0.0, 0.0};  ///< further noise
  double clips_at = 1.0;                ///< part of its range beyond which it is clipped
  double filter = 0.0;  ///< corner and damping of each pair of the filter's poles, up to +- so much
};

struct EncoderScenario {
  double pitch_error_pitches;   ///< rms, zero mean over a turn
  double eccentricity_rad;      ///< amplitude of the once-a-turn error of a ring mounted off centre
  double tooth_offset_pitches;  ///< how far the first tooth comes after the zero mark
  double stamp_jitter_s;        ///< rms
};

/// The drive of the simulated car, as one TOML file states it.
struct Scenario {
  std::uint64_t seed;
  DriveScenario drive;
  RoadScenario road;
  std::array<WheelScenario, kWheels> wheel;
  double parameter_spread;    ///< springs, dampers, stabilisers, tyres lie uniformly within +- this part
  double sigma_spread = 0.0;  ///< masses, inertias, tyre dampers: so many standard deviations of vehicle.toml
  double rolling_radius_spread;  ///< radii of the four wheels differ by up to +- this part
  TyreScenario tyre;
  double forward_hz = 22.0;  ///< at which a carrier swings fore and aft
  SensorScenario sensor;
  EncoderScenario encoder;
  DamperScenario damper;

  double seconds() const;
  /// Stretches every plateau alike so that the drive lasts `seconds`; a drift ends at the same speed.
  void scale_to(double seconds);

  /// A key that the file gives as [low, high] is drawn between them by the seed.
  ///
  /// @param vehicle  weight radii, where the scenario names none
  /// @param seed     nothing: the scenario's
  /// @throws ConfigError naming file, line and key
  static Scenario parse(const std::string& text, const std::string& name_for_errors,
                        const VehicleConfig& vehicle, std::optional<std::uint64_t> seed = {});
  /// @param path  empty: the demo scenario, which is built into the program
  static Scenario read(const std::string& path, const VehicleConfig& vehicle,
                       std::optional<std::uint64_t> seed = {});
};

}  // namespace roadbalance::sim
