#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/compensation.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/order_report.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/remark.hpp"
#include "common/bus/results.hpp"
#include "common/bus/weight_check.hpp"
#include "common/types/clocks.hpp"
#include "common/types/exchange.hpp"
#include "host/recorder/alarm_watch.hpp"
#include "tools/views/sealing_rate.hpp"

namespace roadbalance {

/// The newest of every result and heartbeat on the bus: all that a display may show.
class BusView {
 public:
  explicit BusView(const std::string& url);

  /// Waits up to `timeout`, then takes all that has arrived.  True if an estimate differs from the one
  /// before.
  bool handle(std::chrono::milliseconds timeout);
  /// The last handle() saw a recorder, a node or a clock come, go or change its state: more than counters
  /// that go on.
  bool state_changed() const { return state_changed_; }

  /// For people, since the last call: who on the bus is of another version of the wire.
  std::vector<std::string> other_versions() { return bus_.other_versions(); }

  bool heard_anything() const {
    return identification_ || !levels_.empty() || !heartbeats_.empty() || !recorders_.empty() ||
           !clocks_.empty();
  }
  const std::optional<Identification>& identification() const { return identification_; }
  const std::array<std::optional<Balance>, kWheels>& balance() const { return balance_; }
  /// Steps for the wheel; unknown for a balance that came without them.
  Compensation compensation(std::size_t wheel) const;
  /// Basis of the newest estimate, as far as all of it was heard.
  std::vector<std::string> remarks() const;
  /// Effect of the weights, if the analyser has the drive before them.
  const std::array<std::optional<WeightCheck>, kWheels>& weight_check() const { return weight_check_; }
  const std::map<std::int32_t, Level>& levels() const { return levels_; }
  /// By wheel and node.
  const std::map<std::pair<std::int32_t, std::int32_t>, OrderReport>& orders() const { return orders_; }
  const std::map<std::int32_t, Heartbeat>& heartbeats() const { return heartbeats_; }
  /// Time until a node's memory is full if recording stops; nothing if that is not known.
  std::optional<double> memory_left_s(std::int32_t node) const;
  /// State of the nodes' clocks, by node; none for a node that no recorder asks for its time.
  const std::map<std::int32_t, ClockFit>& clocks() const { return clocks_; }

  /// By RecorderStatus::recorder: two recorders are two lines.
  const std::map<std::int64_t, RecorderStatus>& recorders() const { return recorders_; }

  /// Faults on the bus by the messages heard, beside the recorders' own alarms; the worst first.
  std::vector<ActiveAlarm> alarms() const { return watch_.active(); }

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
  void take(const Heartbeat& beat);
  void take(const ClockFit& fit);
  void take(const OrderReport& report);
  void forget_silent_recorders();

  Bus bus_;
  bool news_ = false;
  bool state_changed_ = false;
  std::optional<Identification> identification_;
  std::array<std::optional<Balance>, kWheels> balance_;
  std::array<std::optional<Compensation>, kWheels> compensation_;
  std::map<std::int32_t, Remark> remarks_;  ///< by number
  std::array<std::optional<WeightCheck>, kWheels> weight_check_;
  std::map<std::int32_t, Level> levels_;
  std::map<std::pair<std::int32_t, std::int32_t>, OrderReport> orders_;
  std::map<std::int32_t, Heartbeat> heartbeats_;
  std::map<std::int32_t, SealingRate> sealing_;
  std::map<std::int32_t, ClockFit> clocks_;
  std::map<std::int64_t, RecorderStatus> recorders_;
  std::map<std::int64_t, WallTime> recorder_heard_at_;
  std::map<std::pair<std::int32_t, std::int32_t>, Line> lines_;
  AlarmWatch watch_;
};

}  // namespace roadbalance
