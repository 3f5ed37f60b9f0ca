#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/config/vehicle_config.hpp"
#include "common/types/block.hpp"
#include "common/types/exchange.hpp"
#include "host/analysis/identify/clipped_channels.hpp"
#include "host/analysis/spectra/channel_watch.hpp"
#include "host/analysis/spectra/levels_in_time.hpp"
#include "host/analysis/spectra/wheel_speeds.hpp"
#include "host/recording/levels.hpp"

namespace roadbalance {

/// Levels of every channel over a whole recording, slip and drift of its wheels, how long each speed was
/// driven.  Fed as read_recording() hands over.
class RecordLevels {
 public:
  RecordLevels() : in_time_([this](const Level& level) { speeds_->take(level); }) {}
  RecordLevels(const RecordLevels&) = delete;
  RecordLevels& operator=(const RecordLevels&) = delete;

  void begin(const VehicleConfig& vehicle);
  void consume(const SealedBlock& block);
  void consume(const ClockFit& fit) { in_time_.take(fit); }

  /// Once, at the end: {"channels": [...], "wheels": [...], "speed_classes": [...]} as `rb levels --json`.
  nlohmann::ordered_json json();

 private:
  /// Levels of a node: over the whole recording, and of each tenth of a second as the analyser sends them
  /// live.
  class NodeLevels {
   public:
    NodeLevels(const VehicleConfig& vehicle, const NodeConfig& node)
        : whole_(vehicle, node), interval_(vehicle, node), clipping_(node) {}

    void add(const ScanBlock& block, ChannelWatch& watch, LevelsInTime& in_time);
    std::optional<Level> whole() { return whole_.take(); }

    std::array<double, kAccelerations> dead_s{}, railed_s{}, clipped_s{};

   private:
    LevelMeter whole_, interval_;
    ClippedChannels clipping_;
    std::uint32_t clipped_ = 0;  ///< in the interval
    double seconds_ = 0.0;
  };

  VehicleConfig vehicle_;
  std::map<std::int32_t, NodeLevels> meters_;
  std::optional<ChannelWatch> watch_;
  std::optional<WheelSpeeds> speeds_;
  LevelsInTime in_time_;
};

}  // namespace roadbalance
