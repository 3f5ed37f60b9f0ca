#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/blocks.hpp"

namespace roadbalance {

/// Levels of one node's channels over intervals: mean, rms and peak about the mean, overload, dead channels,
/// speed and the rotation of its wheels.
class LevelMeter {
 public:
  /// A channel that shows not one count of noise in this many scans carries no signal.
  static constexpr std::int64_t kDeadScans = 100;
  /// Beyond this share of full scale a channel is overloaded, whatever its device reports: the next value may
  /// be clipped.
  static constexpr double kOverloadShare = 0.95;

  LevelMeter(const VehicleConfig& vehicle, const NodeConfig& node);

  void add(const ScanBlock& block);

  /// Levels since the last take(); nothing if no scan came.
  std::optional<Level> take();

 private:
  struct Sums {
    double first = 0;  ///< sums count from it, or squares would lose their digits
    double sum = 0;
    double squares = 0;
    double least = 0;
    double most = 0;
    std::int32_t last = 0;       ///< newest reading
    std::int64_t unchanged = 0;  ///< scans since it last changed, over intervals
  };
  /// The turning of a wheel's reference since the last take().
  struct Turning {
    double turned_rad = 0;
    std::int64_t scans = 0;
    std::optional<std::array<double, 2>> before{};  ///< sin, cos from where the next angle is taken
    int since = 0;                                  ///< scans after them

    double rotation_hz(double period_s) const;  ///< NaN: not known
  };
  void add_turn(int line, const ScanBlock& block, const std::array<std::int32_t, kChannels>& row);

  NodeConfig node_;
  std::optional<int> line_;  ///< encoder line of the node's first wheel
  double rolling_radius_m_ = 0;
  std::array<Sums, kChannels> sums_{};
  std::int64_t scans_ = 0;
  double period_s_ = 0;
  std::int64_t end_ns_ = 0;
  std::uint32_t overload_ = 0;
  std::array<bool, kEncoderLines> has_wheel_{};
  std::array<Turning, kEncoderLines> turning_{};
  std::int64_t next_scan_ = -1;
};

}  // namespace roadbalance
