#include "host/recorder/power/power_watch.hpp"

#include <utility>

namespace roadbalance {

PowerWatch::Event PowerWatch::take_unreadable(WallTime now) {
  if (!unread_since_) unread_since_ = now;
  if (is_unreadable_ || now - *unread_since_ < options_.unreadable) return Event::kNone;
  is_unreadable_ = true;
  return Event::kUnreadable;
}

PowerWatch::Event PowerWatch::take(std::optional<bool> good, WallTime now) {
  if (!good) return take_unreadable(now);
  unread_since_.reset();
  if (std::exchange(is_unreadable_, false)) return Event::kReadable;
  if (*good != on_battery_) {
    differs_since_.reset();
    return Event::kNone;
  }
  if (!differs_since_) differs_since_ = now;
  if (now - *differs_since_ < (on_battery_ ? options_.comeback : options_.loss)) return Event::kNone;
  differs_since_.reset();
  on_battery_ = !on_battery_;
  return on_battery_ ? Event::kLost : Event::kReturned;
}

}  // namespace roadbalance
