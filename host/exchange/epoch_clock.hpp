#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/record/log_event.hpp"
#include "common/record/recorded_clocks.hpp"
#include "host/exchange/survey.hpp"

namespace roadbalance {

/// How a recording tells the time of one node epoch: the host's, by the fit that holds, and before the first
/// by that one; the node's own if no node of the recording has a clock.
class EpochClock {
 public:
  /// @param first_fit   of the epoch; nothing: the recording has none
  /// @param own_clocks  RecordingSurvey::own_clocks()
  EpochClock(const NodeEpoch& key, const std::optional<ClockFit>& first_fit, bool own_clocks);

  /// Any event of the recording; those that say nothing of this clock are passed over.
  void take(const LogEvent& event);
  /// Nothing: behind a break of the time base, until the next fit, or of an epoch that has none.
  std::optional<std::int64_t> time_ns(std::int64_t node_ns) const;

 private:
  const NodeEpoch key_;
  const std::string fits_;  ///< channel
  const std::optional<ClockFit> first_fit_;
  const bool own_clocks_;
  RecordedClocks clocks_;
  bool begun_ = false;  ///< the first fit has come
};

}  // namespace roadbalance
