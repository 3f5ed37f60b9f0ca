#pragma once

#include <map>
#include <vector>

#include "common/bus/control.hpp"
#include "common/link/epoch_receiver.hpp"
#include "host/recorder/recorder.hpp"
#include "host/recorder/recover.hpp"

namespace roadbalance {

/// Counts for the report what was received of each node epoch.
class Tally {
 public:
  explicit Tally(const Recovered& recovered);

  void take(const Heartbeat& heartbeat);
  void take(const Delivery& delivery);
  void take_durable(std::int32_t node, std::int64_t epoch, std::int64_t sequence);

  /// The epochs heard in this run.
  RecorderReport report() const;
  const NodeReport* find(std::int32_t node, std::int64_t epoch) const;

 private:
  NodeReport& of(std::int32_t node, std::int64_t epoch);

  std::map<NodeEpoch, NodeReport> counts_;
  std::vector<NodeEpoch> heard_;  // in order of time
};

}  // namespace roadbalance
