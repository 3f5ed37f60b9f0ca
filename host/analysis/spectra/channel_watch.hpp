#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Finds accelerations that cannot be what the car does, by the levels of all nodes over the last seconds.
///
/// Dead: while the car moves it shows less than kDeadShare of the median rms of the other channels of its
/// kind, those on carriers or those on the body (fewer than two: of all others).  The measure is what
/// neighbours show and not the range: a body shows 0.2 to 0.5 m/s^2 on a good road, which is below 1 % of the
/// usual 50 m/s^2, and a lost cable leaves the converter's noise of 1e-4 of the range and more.
///
/// Railed: its mean is further than kRailShare of the range from 0, and from what gravity makes of a sensor
/// whose zero was not taken; and further than kDriven_m_s2 times the horizontal part of its direction, for a
/// car may brake and bend so hard for a while.  So a sensor without supply, a broken bias, a shifted zero.
class ChannelWatch {
 public:
  static constexpr double kWindow_s = 3.0;
  static constexpr double kMoving_m_s = 20.0 / 3.6;  ///< all through the window, of the wheels that turn
  static constexpr double kDeadShare = 0.05;
  static constexpr double kRailShare = 0.2;
  static constexpr double kDriven_m_s2 = 10.0;

  explicit ChannelWatch(const VehicleConfig& vehicle);

  /// Adds to the level what it finds (channel_faults.hpp).  Levels of a node in order of time; what is not
  /// known is not marked.
  void judge(Level& level);

 private:
  struct Interval {
    double until_s, seconds;
    std::array<double, kAccelerations> mean, square;  ///< m/s^2, its square
  };
  struct Node {
    const NodeConfig* config;
    std::deque<Interval> interval{};
    double still_until_s = 0.0;                        ///< of its own clock: when the car last did not move
    std::array<double, kAccelerations> mean{}, rms{};  ///< over the window; rms NaN: not judged
  };
  void add(const Level& level, Node& node);
  double usual_rms(const ChannelConfig& channel) const;
  static double rail_m_s2(const ChannelConfig& channel);

  VehicleConfig vehicle_;
  std::map<std::int32_t, Node> node_;
  std::map<std::int32_t, double> speed_m_s_;  ///< of nodes with a wheel, newest
};

}  // namespace roadbalance
