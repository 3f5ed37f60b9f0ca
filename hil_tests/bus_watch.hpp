#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/recorder_status.hpp"

namespace roadbalance::test {

/// The view of an observer on the bus: the newest message of each node and of the recorder.  An
/// acknowledgement counts only if it is for the epoch of the node's heartbeat.
class BusWatch {
 public:
  /// @throws std::runtime_error naming the URL
  explicit BusWatch(const std::string& url);

  /// Listens until `condition` holds; false if it does not within `seconds`.  A bound, not a measurement.
  bool wait(const std::function<bool()>& condition, double seconds = kPatience_s);
  /// Listens for so long, come what may: the length of a fault.
  void listen(double seconds);

  /// All zeros if none has come yet.
  Heartbeat heartbeat(std::int32_t node) const;
  Ack ack(std::int32_t node) const;
  const std::optional<RecorderStatus>& recorder() const { return recorder_; }
  /// The newest results of the analyser as they were sent, by channel and wheel.
  const std::map<std::pair<std::string, int>, std::vector<std::uint8_t>>& results() const { return results_; }

  static constexpr double kPatience_s = 60;  // for slow machines and sanitizers

 private:
  Bus bus_;
  std::map<std::int32_t, Heartbeat> heartbeat_;
  std::map<std::int32_t, Ack> ack_;
  std::optional<RecorderStatus> recorder_;
  std::map<std::pair<std::string, int>, std::vector<std::uint8_t>> results_;
};

}  // namespace roadbalance::test
