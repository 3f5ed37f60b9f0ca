#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/bus/alarm.hpp"
#include "common/bus/recorder_status.hpp"

namespace roadbalance {

/// "records to segment 3: 1.2 GB so far, 34 GB free, 5.1 h left".
std::string status_line(const RecorderStatus& status);

struct RecorderAlarm {
  AlarmCause cause = AlarmCause::kRecorderSays;
  std::string text;
  std::int32_t node = 0;  ///< 0: the recorder
};

/// "node 2 does not measure: it has not been heard ..."
std::string words(const RecorderAlarm& alarm);

/// Things that a person should know or do about it, most urgent first; empty if all is well.
std::vector<RecorderAlarm> alarms(const RecorderStatus& status);

}  // namespace roadbalance
