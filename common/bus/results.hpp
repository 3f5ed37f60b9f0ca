#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/bus/transfer_function_report.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Messages that the analyser publishes and every display draws; fields as in common/wire.

struct Level {
  std::int32_t node = 0;
  std::int64_t time_ns = 0;
  double seconds = 0;
  std::array<double, kChannels> mean{}, rms{}, peak{};
  std::uint32_t overload = 0;
  std::uint32_t dead = 0;
  std::uint32_t clipped = 0;
  double speed_m_s = 0;
  std::array<double, kEncoderLines> rotation_hz{};  ///< [encoder line]; NaN: not known
  std::int64_t skipped = 0;
};

inline constexpr int kSpectrumBinsPerPart = 300;
struct SpectrumPart {
  std::int64_t viewer = 0;  ///< of the View that asked; 0: for everybody
  std::int32_t node = 0;
  std::int32_t channel = 0;
  SpectralState state = SpectralState::kComputed;  ///< why it has no bins (yet)
  std::int64_t time_ns = 0;
  std::int32_t part = 0;
  std::int32_t parts = 1;
  double first_hz = 0;
  double step_hz = 0;
  double enbw_hz = 0;
  std::int32_t averages = 0;
  bool held = false;             ///< the greatest that any one segment had
  std::vector<float> density{};  ///< at most kSpectrumBinsPerPart, (m/s^2)^2 / Hz
};

/// Why an estimate cannot be given (yet); 0 = it is given.
enum class Unknown : std::int32_t {
  kNone = 0,
  kTooShort = 1,        ///< not enough driving at a steady speed yet
  kTooSlow = 2,         ///< the car never went fast enough
  kNoReference = 3,     ///< this wheel has no angle
  kIllConditioned = 4,  ///< the drive does not determine it
  kUnfitVehicle = 5,    ///< the vehicle's sensors or rates do not allow it
  kNoCommonTime = 6,    ///< the nodes' samples do not lie on one grid of time
  kInStep = 7,  ///< this wheel turned in step with another, and sensors on the body do not separate them
};

inline constexpr int kMaxSpeedClasses = 16;
struct Identification {
  std::int64_t time_ns = 0;
  double seconds_used = 0;
  std::int32_t sections = 0;
  Unknown state = Unknown::kTooShort;
  double seconds_needed = 0;
  double least_speed_m_s = 0;
  std::array<double, kWheels> spring_n_m{}, sigma_spring_n_m{}, damper_n_s_m{}, sigma_damper_n_s_m{};
  std::array<double, kAxles> stabiliser_n_m{}, sigma_stabiliser_n_m{};
  std::array<double, kWheels> tyre_n_m{}, sigma_tyre_n_m{};
  struct SpeedClass {
    double speed_m_s = 0;
    double seconds = 0;
  };
  std::vector<SpeedClass> speed_class;  ///< at most kMaxSpeedClasses
};

/// Whether the speeds driven separate a wheel's unbalance from a first-order force that does not grow with
/// speed: a tyre's radial force variation.
enum class ForceState : std::int32_t {
  kNotJudged = 0,
  kSeparated = 1,
  kNotSeparable = 2,  ///< the unbalance is the equivalent one of the speeds driven
};

struct Balance {
  std::int32_t wheel = 0;
  std::int64_t time_ns = 0;
  Unknown state = Unknown::kTooShort;
  double unbalance_g = 0;
  double angle_rad = 0;  ///< heavy spot from the reference point in the direction of rotation, 0 .. 2 pi
  Eigen::Matrix2d covariance_g2 = Eigen::Matrix2d::Zero();  ///< of the (cos, sin) components
  double sigma_g = 0;
  double sigma_rad = 0;
  double weight_radius_m = 0;
  double weight_angle_rad = 0;
  double seconds_used = 0;
  double sigma_drive_g = 0;
  double phase_drift_rad = 0;
  double least_speed_m_s = 0;
  double greatest_speed_m_s = 0;
  ForceState force_state = ForceState::kNotJudged;
  double force_n = 0;
  double force_angle_rad = 0;
  double sigma_force_n = 0;
  double alone_g = 0;
  double alone_angle_rad = 0;
  double sigma_alone_g = 0;
};

std::vector<std::uint8_t> encode(const Level& message);
std::vector<std::uint8_t> encode(const SpectrumPart& message);
std::vector<std::uint8_t> encode(const Identification& message);
std::vector<std::uint8_t> encode(const Balance& message);
std::optional<Level> decode_level(std::span<const std::uint8_t> bytes);
std::optional<SpectrumPart> decode_spectrum(std::span<const std::uint8_t> bytes);
std::optional<Identification> decode_identification(std::span<const std::uint8_t> bytes);
std::optional<Balance> decode_balance(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
