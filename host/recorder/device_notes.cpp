#include "host/recorder/device_notes.hpp"

#include <algorithm>

namespace roadbalance {

void DeviceNotes::note(std::int32_t node, std::size_t counter, std::vector<DeviceNote>& notes) {
  Counter& c = counter_[counter];
  c.noted = c.heard;
  const auto which = static_cast<DeviceCounter>(counter);
  notes.push_back({.node = node, .counter = which, .text = sentence(which, c.heard)});
}

void DeviceNotes::take(std::span<const std::int64_t, kDeviceCounters> counts) {
  for (std::size_t k = 0; k < kDeviceCounters; ++k)  // an old heartbeat may come behind a newer one
    counter_[k].heard = std::max(counter_[k].heard, counts[k]);
}

void DeviceNotes::due(std::int32_t node, WallTime now, std::vector<DeviceNote>& notes) {
  for (std::size_t k = 0; k < kDeviceCounters; ++k) {
    Counter& c = counter_[k];
    if (c.heard == c.noted || (c.noted > 0 && now - c.noted_at < kPeriod)) continue;
    c.noted_at = now;
    note(node, k, notes);
  }
}

void DeviceNotes::finish(std::int32_t node, std::vector<DeviceNote>& notes) {
  for (std::size_t k = 0; k < kDeviceCounters; ++k)
    if (counter_[k].heard != counter_[k].noted) note(node, k, notes);
}

}  // namespace roadbalance
