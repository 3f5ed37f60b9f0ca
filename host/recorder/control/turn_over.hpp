#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/config/vehicle_config.hpp"
#include "common/types/clocks.hpp"
#include "common/vehicle/gravity.hpp"

namespace roadbalance {

/// A channel's scale by gravity: what it reads at rest with its positive direction up, then down.
///
///     scale = 2 g / (up - down),   offset = (up + down) / 2
///
/// An accelerometer at rest whose axis points up reads +g.  g is kStandardGravity_m_s2; where the car stands
/// it is 0.3 % more or less, and an axis 3 degrees off the vertical reads 0.14 % less.  A sensor that does
/// not measure what is steady (one with a high-pass filter) has no scale by gravity and is refused.
///
/// Source: IEEE Std 1293-2018, the two-position test.  A pure state machine of bounded memory.
class TurnOver {
 public:
  static constexpr double kMostOff = 0.2;  ///< farther from the scale in force it is a mistake, not a scale
  static constexpr std::chrono::minutes kPatience{10};  ///< between the two readings

  struct Calibration {
    double scale_m_s2_per_count;
    double offset_counts;
  };
  struct Result {
    std::optional<Calibration> found{};
    bool is_refused = false;
    std::string text{};  ///< for people: what is next, or why not
  };
  /// @param channel      of the node, from 0
  /// @param mean_counts  that it reads at rest
  Result take(const NodeConfig& node, int channel, bool is_up, double mean_counts, WallTime now);
  /// Another range or scale: what was read means something else.
  void forget() { read_.clear(); }

 private:
  struct Reading {
    std::optional<double> counts[2];  ///< down, up
    WallTime at[2]{};
  };
  std::map<std::pair<std::int32_t, int>, Reading> read_;  // by node and channel
};

}  // namespace roadbalance
