#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "sim/damper.hpp"

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

struct RoadScenario {
  double roughness_m3;  ///< Gd(n0) of ISO 8608, n0 = 0.1 1/m; 0 is a flat road
  double left_right_correlation;
  double rear_coherence2;  ///< squared coherence of the road under a rear wheel with its front wheel's
};

/// Complex amplitudes by wheel, phase from the reference point in the direction of rotation (conventions.md).
struct WheelScenario {
  std::complex<double> unbalance_kg_m{};
  std::complex<double> radial_force_n{};
};

struct SensorScenario {
  double noise_m_s2;              ///< rms of what is converted
  double coupling_from_vertical;  ///< vertical acceleration seen by a horizontal sensor
  double coupling_into_vertical;  ///< each horizontal acceleration seen by a vertical sensor
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
  double parameter_spread;       ///< springs, dampers, stabilisers, tyres lie uniformly within +- this part
  double rolling_radius_spread;  ///< radii of the four wheels differ by up to +- this part
  SensorScenario sensor;
  EncoderScenario encoder;
  DamperScenario damper;

  double seconds() const;
  /// Stretches every plateau alike so that the drive lasts `seconds`; a drift ends at the same speed.
  void scale_to(double seconds);

  /// @param vehicle  weight radii, where the scenario names none
  /// @throws ConfigError naming file, line and key
  static Scenario parse(const std::string& text, const std::string& name_for_errors,
                        const VehicleConfig& vehicle);
  /// @param path  empty: the demo scenario, which is built into the program
  static Scenario read(const std::string& path, const VehicleConfig& vehicle);
};

}  // namespace roadbalance::sim
