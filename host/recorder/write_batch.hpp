#pragma once

#include <optional>
#include <vector>

#include "host/recorder/alarm_log.hpp"
#include "host/recorder/recorder_link.hpp"
#include "host/recorder/recording_store.hpp"

namespace roadbalance {

/// From the link to the writer.
struct WriteBatch {
  std::vector<Delivery> deliveries;
  std::optional<LinkCounters> counters{};  ///< about once a second
  std::vector<DeviceNote> device_notes{};
  std::vector<NoteToRecord> notes{};
  std::vector<AlarmNote> alarm_notes{};

  bool has_content() const {
    return !deliveries.empty() || counters || !device_notes.empty() || !notes.empty() || !alarm_notes.empty();
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
void append(RecordingStore& store, const WriteBatch& batch, WallTime now);

}  // namespace roadbalance
