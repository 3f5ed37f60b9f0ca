#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/record/log_event.hpp"
#include "common/record/recorded_clocks.hpp"
#include "host/recording/formats/survey.hpp"

namespace roadbalance {

/// The time of one node epoch in a recording: the host's, by the fit that holds, and before the first fit by
/// that one; the node's own if the recording has no fit of any node.
class EpochClock {
 public:
  /// @param first_fit   of the epoch; nothing: the recording has none
  /// @param own_clocks  RecordingSurvey::own_clocks()
  EpochClock(const NodeEpoch& key, const std::optional<ClockFit>& first_fit, bool own_clocks);

  /// Takes any event of the recording; those of other clocks are ignored.
  void take(const LogEvent& event);
  /// Nothing behind a break of the time base, until the next fit, and for an epoch without a fit.
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
