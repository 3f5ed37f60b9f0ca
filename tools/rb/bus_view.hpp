#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/control.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/results.hpp"
#include "common/clock/clocks.hpp"

namespace roadbalance {

/// The newest of every result and heartbeat on the bus: all that a display may know.
class BusView {
 public:
  explicit BusView(const std::string& url);

  /// Waits up to `timeout`, then takes all that has arrived.  True if an estimate differs from the one
  /// before.
  bool handle(std::chrono::milliseconds timeout);

  const std::optional<Identification>& identification() const { return identification_; }
  const std::array<std::optional<Balance>, kWheels>& balance() const { return balance_; }
  const std::map<std::int32_t, Level>& levels() const { return levels_; }
  const std::map<std::int32_t, Heartbeat>& heartbeats() const { return heartbeats_; }

  /// By incarnation: two recorders are two lines.
  const std::map<std::int64_t, RecorderStatus>& recorders() const { return recorders_; }

  /// The highest line of a channel's spectrum, from the parts seen last.
  struct Line {
    double frequency_hz = 0;
    double density = 0;  ///< (m/s^2)^2 / Hz
  };
  /// By node and channel.
  const std::map<std::pair<std::int32_t, std::int32_t>, Line>& highest_lines() const { return lines_; }

 private:
  void take(const SpectrumPart& part);
  void take(const RecorderStatus& status);
  void forget_silent_recorders();

  Bus bus_;
  bool news_ = false;
  std::optional<Identification> identification_;
  std::array<std::optional<Balance>, kWheels> balance_;
  std::map<std::int32_t, Level> levels_;
  std::map<std::int32_t, Heartbeat> heartbeats_;
  std::map<std::int64_t, RecorderStatus> recorders_;
  std::map<std::int64_t, WallTime> recorder_heard_at_;
  std::map<std::pair<std::int32_t, std::int32_t>, Line> lines_;
};

}  // namespace roadbalance
