#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "host/analysis/twin/sample_history.hpp"
#include "host/analysis/twin/sensor_samples.hpp"
#include "host/analysis/twin/twin_car.hpp"
#include "host/analysis/twin/twin_channels.hpp"
#include "host/analysis/twin/twin_motion.hpp"

namespace roadbalance {

/// Why a part of the car is not predicted.
enum class TwinState : std::int32_t {
  kPredicted = 0,
  kSettling = 1,  ///< after a hole, or a changed car: what was before it still shows
  kNoSpeed = 2,   ///< no wheel's angle is known, nor how far the car has rolled
  kTooSlow = 3,   ///< it takes longer for its wheelbase than the twin is behind
};

/// Measured and predicted at one instant.
struct TwinSample {
  std::int64_t time_ns = 0;
  double speed_m_s = 0.0;  ///< 0: not known
  std::array<TwinState, kTwinParts> state{};
  Eigen::VectorXd measured, predicted;  ///< [channels], m/s^2; a part's not predicted: not to be used
};

/// The car simulated beside the measurement (twin_motion.hpp), kBehind samples behind it.
///
/// Only the sensors of the four carriers go in; those on the body are only compared.  The body is
/// predicted from what the wheels do; each axle's wheels from what the other axle has shown of the road that
/// comes under them, or has come: rear wheels from before, front wheels from after, which is why it runs
/// behind.  How far apart in time that is, is how long the car took to roll its wheelbase, of each side its
/// own, whatever the speed did meanwhile.
///
/// After a restart all begins anew; nothing is predicted until the state before has decayed to kSettled.
class Twin {
 public:
  static constexpr int kBehind = 320;  ///< samples: 0.64 s at 500 Hz
  static constexpr double kSettled = 1e-3;
  /// A car that differs by more than this (greatest_difference()) settles anew.
  static constexpr double kOtherCar = 0.02;

  /// @throws ConfigError as TwinChannels; std::invalid_argument if the car's motion does not decay
  Twin(const TwinChannels& channels, const TwinCar& car, double rate_hz);

  /// The same car, known better.
  /// @throws std::invalid_argument if its motion does not decay; the twin then goes on with the one it has
  void change(const TwinCar& car);
  const TwinCar& car() const { return car_; }
  double behind_s() const { return kBehind / rate_hz_; }
  double settling_s() const;

  /// Takes a sample; nothing until the first is kBehind behind.  Never allocates.
  /// @return valid until the next call
  const TwinSample* consume(const SensorSample& sample);

 private:
  /// The instant at which the other axle stands where this one stands, of one side.
  struct Meeting {
    std::int64_t n = 0;
    double fraction = 0.0;
  };
  struct Axle {
    MotionFilter filter;
    std::array<Meeting, 2> meeting{};
    std::int64_t fed = 0;
    TwinState refusal = TwinState::kSettling;
    Eigen::Vector2d wheels = Eigen::Vector2d::Zero();
  };
  MotionFilter make(const MotionEquation& equation) const;
  TwinState state(const MotionFilter& filter, std::int64_t fed) const;
  void restart();
  void step(std::int64_t next);
  void step_axle(int axle, std::int64_t next);
  TwinState meet(int axle, int side, std::int64_t next, Meeting& meeting) const;

  TwinChannels channels_;
  TwinCar car_;
  double rate_hz_;
  LinearModel model_;
  SampleHistory history_;
  MotionFilter body_;
  std::int64_t body_fed_ = 0;
  std::array<Axle, kAxles> axle_;
  Eigen::VectorXd axle_input_;
  Vector7 coordinates_ = Vector7::Zero();
  TwinSample out_;
};

}  // namespace roadbalance
