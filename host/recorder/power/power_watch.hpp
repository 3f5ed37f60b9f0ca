#pragma once

#include <optional>

#include "common/types/clocks.hpp"

namespace roadbalance {

/// From readings of a power line to the two events that matter; a pure state machine.
///
/// The supply is gone when it was bad for `loss`, and back when it was good for `comeback`: a starter motor's
/// dip neither closes segments nor ends the battery's time too soon.  A reading that fails leaves the state;
/// if none succeeds for `unreadable`, that is an event of its own, and so is the next success.
class PowerWatch {
 public:
  struct Options {
    std::chrono::milliseconds loss{100};
    std::chrono::milliseconds comeback{2000};
    std::chrono::milliseconds unreadable{1000};
  };
  enum class Event { kNone, kLost, kReturned, kUnreadable, kReadable };

  PowerWatch() : PowerWatch(Options{}) {}
  explicit PowerWatch(Options options) : options_(options) {}

  Event take(std::optional<bool> good, WallTime now);

  bool on_battery() const { return on_battery_; }
  bool is_unreadable() const { return is_unreadable_; }

 private:
  Event take_unreadable(WallTime now);

  const Options options_;
  bool on_battery_ = false;
  std::optional<WallTime> differs_since_;  // readings are the opposite of on_battery_ since then
  std::optional<WallTime> unread_since_;
  bool is_unreadable_ = false;
};

}  // namespace roadbalance
