#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/config/node_wiring.hpp"
#include "common/config/weight_stock.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

/// In this order everywhere.
inline constexpr int kWheels = 4;
inline constexpr std::array<const char*, kWheels> kWheelNames{"front_left", "front_right", "rear_left",
                                                              "rear_right"};
inline constexpr int kAxles = 2;  ///< front, rear

/// Standard deviations where vehicle.toml gives none: a wheel weighed with its carrier, a car weighed with
/// the people in it, inertias from a table, the damping of a tyre that rolls.
inline constexpr double kWheelMassSigma = 0.02;
inline constexpr double kBodyMassSigma = 0.03;
inline constexpr double kInertiaSigma = 0.10;
inline constexpr double kTyreDamperSigma_n_s_m = 50.0;

/// [model]: parameters of the 7-degree-of-freedom car, kind = "seven_dof", or of kind = "description" the
/// file that describes a car of another form (common/multibody), which can be recorded but not identified.
/// Axes: x forward, y left, z up; origin in the body's centre of mass.  Both wheels of an axle are alike
/// here; identification finds each wheel's own values, starting from these.
struct AxleConfig {
  double x_m;                            ///< of the axle; rear is negative
  double half_track_m;                   ///< left wheel at +, right at -
  double spring_n_m;                     ///< each suspension spring, at the wheel
  double damper_n_s_m;                   ///< each damper, at the wheel
  double stabiliser_n_m;                 ///< acts on the difference of left and right suspension stretch
  double tyre_n_m;                       ///< vertical stiffness of each tyre
  double tyre_damper_n_s_m = 0.0;        ///< vertical damping of each tyre
  double tyre_damper_sigma_n_s_m = 0.0;  ///< how well it is known, one standard deviation: no drive shows it
};
struct ModelConfig {
  double body_mass_kg;
  double roll_inertia_kg_m2;
  double pitch_inertia_kg_m2;
  /// How well these three are known, one standard deviation.  All stiffnesses that are found are in
  /// proportion to them.
  double body_mass_sigma_kg;
  double roll_inertia_sigma_kg_m2;
  double pitch_inertia_sigma_kg_m2;
  std::array<AxleConfig, kAxles> axle;  ///< [model.front], [model.rear]
  std::string description{};            ///< file of kind = "description"; empty: seven_dof
};

/// [[wheel]]
struct EncoderConfig {
  int pulses_per_turn = 0;  ///< teeth of an ABS ring, lines of a transducer
  bool zero_mark = true;    ///< one zero mark a turn
  bool quadrature = false;  ///< a second track, which shows the direction, is wired to the USB board
  /// Wheel angle (reference point at the upward vertical = 0) at the instant the zero mark fires.
  double datum_rad = 0.0;
  double datum_sigma_rad = 0.0;  ///< its standard deviation, as calibration found it
  /// The angle that a transducer fixed to the body gains when the steering wheel turns left by 1 rad; 0: it
  /// is fixed to the wheel's carrier.
  double steering_ratio = 0.0;
  /// Teeth come from this pulse counter on the bus, only the zero mark from the line; empty: both from the
  /// line.
  std::string counter{};
};
struct WheelConfig {
  std::string name;      ///< one of kWheelNames
  double mass_kg;        ///< unsprung mass moving with the wheel, mounted transducer included
  double mass_sigma_kg;  ///< how well it is known, one standard deviation: unbalances are in proportion to it
  /// The part of it that turns: tyre, rim, hub, disc.  ISO 21940-11 judges an unbalance by the mass of the
  /// rotor.
  std::optional<double> rotating_mass_kg{};
  double rolling_radius_m;
  double weight_radius_m;           ///< where weights are clipped; grams of unbalance refer to it
  WeightStock stock;                ///< [weights], on the places of this wheel
  std::vector<WheelWeight> fitted;  ///< [[wheel.weight]]: those on it during the drive
  std::string node;                 ///< node that reads the encoder; empty: no encoder
  int line = 0;                     ///< which of the node's encoder lines
  EncoderConfig encoder;
};

/// [limits]: what a wheel is judged by.
struct BalanceLimits {
  /// Static unbalance that a shop leaves: balancing machines show less as nothing (usual thresholds 5 .. 7
  /// g).
  double shop_g = 7.0;
  /// ISO 21940-11 (before: ISO 1940-1), table 1: cars, wheels, wheel rims and wheel sets are of grade G 40.
  double grade_mm_s = 40.0;
  /// A wheel that needs more is usually mounted anew, its tyre turned on the rim.
  double heaviest_g = 60.0;
  /// First harmonic of radial force variation at which tyres are usually matched or refused, about 20 lbf.
  double force_n = 90.0;
  /// Standard deviation to which an unbalance is wanted: less than half a step of the usual weights.
  double sigma_g = 2.0;
};

/// [[seat]]: where vibration is to be little.
struct SeatConfig {
  std::string name;
  Eigen::Vector3d position_m{0, 0, 0};  ///< from the body's centre of mass
  double weight = 1.0;                  ///< > 0, of its mean square beside that of the others
};

/// [[rotor.plane]]: where weights can be put on a rotor.
struct PlaneConfig {
  std::string name;
  Eigen::Vector3d position_m{0, 0, 0};  ///< from the body's centre of mass
  double weight_radius_m;
};

/// [[rotor]]: what turns with wheels at a fixed ratio, e.g. a drive shaft.
struct RotorConfig {
  std::string name;
  std::vector<int> wheel;  ///< places in VehicleConfig::wheel; of several the mean turns it (a differential)
  double ratio;            ///< turns of it in a turn of the wheel
  std::vector<PlaneConfig> plane;
};

enum class ChannelRole { kAcceleration, kRoad, kUnused };

/// [[node.channel]]
struct ChannelConfig {
  std::string name;
  ChannelRole role = ChannelRole::kAcceleration;
  std::string mount;  ///< "body" or the wheel whose carrier it sits on; for role road: the wheel
  Eigen::Vector3d position_m{0, 0, 0};  ///< from the body's centre of mass, x forward, y left, z up
  Eigen::Vector3d direction{0, 0, 1};   ///< unit vector of positive acceleration
  double range_m_s2 = 0.0;              ///< full scale of the converter
  double scale_m_s2_per_count = 0.0;    ///< calibration; default range / 2^23
  double offset_counts = 0.0;           ///< reading at rest
  /// Standard deviation of its gain, as a share of it, and of what it shows of motion across its direction.
  double gain_sigma = 0.01;
  double delay_s = 0.0;  ///< by which it lags what it measures, filter of [filter] apart
  /// Voltage of that full scale, of a device with ranges to choose from; its widest if not given.
  std::optional<double> input_range_v{};

  double to_si(double counts) const { return (counts - offset_counts) * scale_m_s2_per_count; }
};

/// [[node]]
struct NodeConfig {
  std::string name;
  int id;                              ///< 1 .. kLastNode, unique
  double rate_hz;                      ///< scans a second, the same for all nodes
  std::vector<ChannelConfig> channel;  ///< 1 .. 12, in converter order
  NodeWiring wiring{};
};

/// [filter]: the anti-aliasing filter that accelerations pass before conversion.
struct FilterConfig {
  int order = 6;
  double cutoff_hz = 200.0;
};

/// [road]: a measured road is a set of channels of role road; wheel paths then count as known inputs.
struct RoadConfig {
  bool measured = false;
};

/// [drive]: what identification takes from a drive.
struct DriveConfig {
  double identification_rate_hz = 500.0;
  double section_s = 10.0;        ///< length of one section of the estimate
  double speed_class_m_s = 2.0;   ///< width of a speed class
  double least_speed_m_s = 15.0;  ///< slower sections are not used
};

/// vehicle.toml: the wiring of a drive and what is known of the car.
struct VehicleConfig {
  std::string name;
  ModelConfig model;
  std::array<WheelConfig, kWheels> wheel;
  BalanceLimits limits;
  std::vector<SeatConfig> seat;
  std::vector<RotorConfig> rotor;
  static constexpr std::size_t kMostChannels = 1024;  ///< of all nodes
  std::vector<NodeConfig> node;
  FilterConfig filter;
  RoadConfig road;
  DriveConfig drive;
  std::string text;    ///< the file as it was read; goes into every record
  std::string folder;  ///< where it was read; other files it names lie relative to that

  /// @throws ConfigError "file:line: key: reason; allowed: ..."
  static VehicleConfig parse(const std::string& text, const std::string& name_for_errors);
  /// @throws std::system_error if the file cannot be read; else as parse
  static VehicleConfig read_file(const std::string& path);

  /// @throws ConfigError if there is no such node
  const NodeConfig& node_named(const std::string& node_name) const;
  const NodeConfig* node_with_id(int id) const;
  /// nullptr if there is none of that name.
  const WheelConfig* wheel_named(const std::string& wheel_name) const;
  /// nullptr if there is none of that name.
  const RotorConfig* rotor_named(const std::string& rotor_name) const;
  /// Wheel read by `line` of `node`; nullptr: none.
  const WheelConfig* wheel_at(const NodeConfig& node, int line) const;
  /// Place of one of its wheels in `wheel`.
  int place_of(const WheelConfig& one) const { return static_cast<int>(&one - wheel.data()); }
};

}  // namespace roadbalance
