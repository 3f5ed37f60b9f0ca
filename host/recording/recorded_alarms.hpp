#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/alarm.hpp"
#include "common/bus/notes.hpp"
#include "host/recording/set_clocks.hpp"

namespace roadbalance {

/// An alarm as the record has it, by its notes of begin and end.
struct RecordedAlarm {
  Alarm alarm{};
  std::int64_t began_us = 0;
  std::optional<std::int64_t> ended_us{};  ///< nothing: the recorder was killed before
  std::string text{};                      ///< amount and duration
};

/// Collects alarms in the order in which they began, from notes in the order of the record.  A pure state
/// machine of bounded memory, whatever the record holds: each note takes O(log kMostOfALevel).
class RecordedAlarms {
 public:
  /// Limit for each level, so that a flood of notices hides no alarm; a recorder writes some hundred a day.
  static constexpr std::size_t kMostOfALevel = 10'000;

  /// Every note: what sets the clock moves the times of alarms, too.
  void take(const Note& note);
  std::vector<RecordedAlarm> all() const;
  /// Alarms that are not in all(), since there were too many.
  std::size_t left_out() const { return left_out_; }

 private:
  struct Kept {
    RecordedAlarm alarm{};  // without its instants
    SetClocks::Stamp began{};
    std::optional<SetClocks::Stamp> ended{};
  };

  SetClocks clocks_;
  std::vector<Kept> all_;
  std::array<std::size_t, 3> kept_{};     // by level
  std::map<Alarm, std::size_t> running_;  // begun and not over: places in all_
  std::size_t left_out_ = 0;
};

/// "ALARM node 1: samples lost (35 samples by now; it lasted 12 s, until 10 s ago)"
std::string sentence(const RecordedAlarm& alarm);

}  // namespace roadbalance
