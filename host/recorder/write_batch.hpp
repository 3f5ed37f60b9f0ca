#pragma once

#include <optional>
#include <vector>

#include "host/recorder/alarm_log.hpp"
#include "host/recorder/record_keeper.hpp"
#include "host/recorder/recorder_link.hpp"

namespace roadbalance {

/// From the link to the writer.
struct WriteBatch {
  std::vector<Delivery> deliveries;
  std::optional<LinkCounters> counters{};  ///< about once a second
  std::vector<DeviceNote> device_notes{};
  std::vector<AlarmNote> alarm_notes{};

  bool says_something() const {
    return !deliveries.empty() || counters || !device_notes.empty() || !alarm_notes.empty();
  }
};

/// Makes them of what a link has.
class BatchMaker {
 public:
  WriteBatch take(RecorderLink& link, WallTime now);
  /// The last one: with the counters if there is anything else.
  static WriteBatch take_last(RecorderLink& link);

 private:
  WallTime counted_at_{};
};

/// Puts one into the record.
void append(RecordKeeper& keeper, const WriteBatch& batch, WallTime now);

}  // namespace roadbalance
