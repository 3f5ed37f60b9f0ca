#include "firmware/backends/gpio/event_order.hpp"

#include <algorithm>
#include <cassert>

namespace roadbalance {

bool EventOrder::add(const InputEvent& event) noexcept {
  assert(held_ < events_.size());
  if (event.monotonic_ns < given_ns_) return false;
  // Behind those of its instant that came before it: they are nearer to the end.
  const auto end = events_.begin() + static_cast<std::ptrdiff_t>(held_);
  const auto place = std::lower_bound(
      events_.begin(), end, event.monotonic_ns,
      [](const InputEvent& held, std::int64_t time_ns) { return held.monotonic_ns > time_ns; });
  std::move_backward(place, end, end + 1);
  *place = event;
  ++held_;
  return true;
}

std::optional<InputEvent> EventOrder::take_before(std::int64_t until_ns) noexcept {
  if (held_ == 0 || events_[held_ - 1].monotonic_ns >= until_ns) return std::nullopt;
  given_ns_ = events_[held_ - 1].monotonic_ns;
  return events_[--held_];
}

}  // namespace roadbalance
