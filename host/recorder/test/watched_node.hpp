#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "host/recorder/alarm_watch.hpp"

namespace roadbalance::test {

/// A node that our recorder has started.
class WatchedNode : public ::testing::Test {
 protected:
  static constexpr std::int64_t kOurs = 17;
  using Alarms = std::vector<Alarm>;

  WatchedNode() {
    beat.node = 3;
    beat.epoch = 5;
    beat.owner = kOurs;
    beat.state = NodeState::kStarted;
    beat.time_base = TimeBase::kShared;
    watch.take(beat, now);
  }
  Alarms active() const {
    Alarms alarms;
    for (const auto& on : watch.active()) alarms.push_back(on.alarm);
    return alarms;
  }

  AlarmWatch watch{kOurs};
  WallTime now{std::chrono::seconds(100)};
  Heartbeat beat;
};

}  // namespace roadbalance::test
