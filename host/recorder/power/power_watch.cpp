#include "host/recorder/power/power_watch.hpp"

namespace roadbalance {

PowerWatch::Event PowerWatch::take(std::optional<bool> good, WallTime now) {
  if (!good) {
    ++unreadable_;
    return Event::kNone;
  }
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
