#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "common/bus/alarm.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// A note about an alarm for the record: one when it began, one when it is over.
struct AlarmNote {
  bool began = true;
  Alarm alarm{};
  std::string text;  ///< "35 samples by now"; "4211 samples by now; it lasted 12 s, until 10 s ago"
};

/// An alarm that is on.
struct ActiveAlarm {
  Alarm alarm{};
  std::string text;
  WallTime since{};
};

/// Raises of alarms -> what begins and what ends.  A pure state machine.
///
/// Whoever sees an alarm raises it again and again while it lasts; one that was not raised for hold() is
/// over, as of its last raise.  An alarm that keeps coming back is held twice as long each time, so that one
/// that flaps writes some twenty notes in its first hour and a dozen in each that follows, whatever it does.
class AlarmLog {
 public:
  static constexpr std::chrono::seconds kHold{10};
  static constexpr std::chrono::seconds kLongestHold{640};
  /// Different alarms; more, by forged numbers of nodes, are passed over.
  static constexpr std::size_t kMostAlarms = 512;

  void raise(const Alarm& alarm, std::string text, WallTime now);
  /// Notes that are due.
  std::vector<AlarmNote> due(WallTime now);
  /// Nothing is raised any more: the end of all that is on.
  std::vector<AlarmNote> finish(WallTime now);
  /// The worst first.
  std::vector<ActiveAlarm> active() const;

 private:
  struct State {
    std::string text{};
    WallTime since{}, last{};
    int times = 0;  // that it began
    bool is_on = false;
    bool is_noted = false;  // that it is on
  };
  static std::chrono::seconds hold(const State& state);
  static AlarmNote begin_of(const Alarm& alarm, const State& state, WallTime now);

  std::map<Alarm, State> state_;
};

}  // namespace roadbalance
