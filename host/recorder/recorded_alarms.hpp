#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/alarm.hpp"
#include "common/bus/notes.hpp"

namespace roadbalance {

/// An alarm as the record tells it: of its notes when it began and when it was over.
struct RecordedAlarm {
  Alarm alarm{};
  std::int64_t began_us = 0;
  std::optional<std::int64_t> ended_us{};  ///< nothing: the recorder was killed before
  std::string text{};                      ///< how much, how long
};

/// In the order in which they began, from notes in the order of the record.  A pure state machine.
class RecordedAlarms {
 public:
  void take(const Note& note);
  const std::vector<RecordedAlarm>& all() const { return all_; }

 private:
  std::vector<RecordedAlarm> all_;
};

/// "ALARM node 1: samples lost (35 samples by now; it lasted 12 s, until 10 s ago)"
std::string sentence(const RecordedAlarm& alarm);

/// @throws std::runtime_error if the folder is no recording
std::vector<RecordedAlarm> recorded_alarms(const std::filesystem::path& folder);

}  // namespace roadbalance
