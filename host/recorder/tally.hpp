#pragma once

#include <map>
#include <optional>
#include <vector>

#include "common/bus/control.hpp"
#include "common/bus/notes.hpp"
#include "common/link/epoch_receiver.hpp"
#include "common/record/record_state.hpp"
#include "host/recorder/epoch_sums.hpp"
#include "host/recorder/recorder.hpp"

namespace roadbalance {

/// Counts for the report what was received of each node epoch.
class Tally {
 public:
  explicit Tally(const RecordState& recovered);

  /// Of an epoch that is being received.
  void take(const Heartbeat& heartbeat);
  void take(const Delivery& delivery);

  /// The epochs received in this run.
  RecorderReport report() const;
  /// Of each of them what its heartbeats have said so far.
  const std::map<NodeEpoch, NodeLosses>& losses() const { return losses_; }

 private:
  NodeReport& of(std::int32_t node, std::int64_t epoch);

  std::map<NodeEpoch, NodeReport> counts_;
  std::map<NodeEpoch, NodeLosses> losses_;
  EpochSums sums_;
  std::vector<NodeEpoch> heard_;  // in order of time
};

}  // namespace roadbalance
