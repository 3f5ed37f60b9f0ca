#pragma once

#include <map>

#include "host/recording/formats/epoch_clock.hpp"

namespace roadbalance {

/// The clocks of a recording's node epochs, as far as it has been read.
class EpochClocks {
 public:
  explicit EpochClocks(const RecordingSurvey& survey) {
    for (const RecordedSpan& span : survey.span)
      if (span.first_fit || !survey.own_clocks())
        clock_.try_emplace({span.node, span.epoch}, NodeEpoch{span.node, span.epoch}, span.first_fit,
                           survey.own_clocks());
  }

  void take(const LogEvent& event) {
    for (auto& [key, clock] : clock_) clock.take(event);
  }
  /// nullptr: an epoch without a sample, or one without a fit beside others that have one.
  const EpochClock* of(const NodeEpoch& key) const {
    const auto found = clock_.find(key);
    return found == clock_.end() ? nullptr : &found->second;
  }

 private:
  std::map<NodeEpoch, EpochClock> clock_;
};

}  // namespace roadbalance
