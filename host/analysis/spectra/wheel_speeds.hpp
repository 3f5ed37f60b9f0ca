#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// How fast the car was driven for how long, and how its wheels turned against one another, by the levels of
/// all nodes.
///
/// Each level of the node that reads the first wheel of all is an instant; what other nodes reported last,
/// and not longer ago than kOldest_s, belongs to it.
class WheelSpeeds {
 public:
  static constexpr double kOldest_s = 0.5;
  static constexpr double kLeast_hz = 0.5;  ///< slower, nobody asks for slip
  static constexpr int kLastClass = 9999;   ///< whatever is faster, in either direction

  explicit WheelSpeeds(const VehicleConfig& vehicle);

  /// In the order of their time, as LevelsInTime gives them.
  void take(const Level& level);

  struct Wheel {
    double seconds = 0.0;  ///< of which its rotation is known
    double turns = 0.0;
    /// By which share it turns faster than the mean of all wheels, while all with an encoder are known; NaN:
    /// never, or there is no other.
    double slip = 0.0;
  };
  std::array<Wheel, kWheels> wheels() const;

  /// The arc that the angle between two wheels went through, radians; NaN: never seen together.
  double drift_rad(int a, int b) const;

  /// Seconds by class of the car's speed: class k from k to k + 1 times class_m_s().
  const std::map<int, double>& classes() const { return class_s_; }
  double class_m_s() const { return class_m_s_; }

 private:
  struct Turning {
    std::optional<double> hz{};
    double at_s = 0.0;  ///< of the instants' count
    double seconds = 0.0, turns = 0.0;
  };
  struct Drift {
    double now = 0.0, least = 0.0, most = 0.0;
    bool seen = false;
  };
  void instant(double seconds);

  double class_m_s_;
  std::map<std::int32_t, std::array<int, kEncoderLines>> wheel_of_;  ///< [node][line]; -1: none
  std::array<double, kWheels> rolling_radius_m_{};
  std::optional<std::int32_t> pace_;  ///< node whose levels are the instants
  int with_encoder_ = 0;
  double clock_s_ = 0.0;
  std::array<Turning, kWheels> turning_{};
  std::array<double, kWheels> together_turns_{};  ///< while all were known
  std::array<std::array<Drift, kWheels>, kWheels> drift_{};
  std::map<int, double> class_s_;
};

}  // namespace roadbalance
