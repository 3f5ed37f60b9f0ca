#pragma once

#include <map>
#include <optional>
#include <vector>

#include "common/bus/control_messages.hpp"
#include "common/bus/notes.hpp"
#include "common/link/epoch_receiver.hpp"
#include "common/record/record_state.hpp"
#include "host/recorder/epoch_sums.hpp"
#include "host/recorder/recorder.hpp"

namespace roadbalance {

/// Counts for the report what was received of each node epoch.
class EpochCounters {
 public:
  explicit EpochCounters(const RecordState& recovered);

  /// The epoch is being received.
  void take(const Heartbeat& heartbeat);
  void take(const Delivery& delivery);

  /// The epochs received in this run.
  RecorderReport report() const;
  /// By their heartbeats so far, for each of these epochs.
  const std::map<NodeEpoch, NodeLosses>& losses() const { return losses_; }

 private:
  NodeReport& of(std::int32_t node, std::int64_t epoch);

  std::map<NodeEpoch, NodeReport> counts_;
  std::map<NodeEpoch, NodeLosses> losses_;
  EpochSums sums_;
  std::vector<NodeEpoch> heard_;  // in order of time
};

}  // namespace roadbalance
