#include "host/recorder/held_events.hpp"

#include <cassert>
#include <utility>

namespace roadbalance {

void HeldEvents::push(std::string_view channel, std::span<const std::uint8_t> data,
                      std::int64_t timestamp_us) {
  places_.push_back({bytes_.size(), channel.size(), data.size(), timestamp_us});
  bytes_.insert(bytes_.end(), channel.begin(), channel.end());
  bytes_.insert(bytes_.end(), data.begin(), data.end());
}

void HeldEvents::clear() {
  bytes_.clear();
  places_.clear();
}

std::int64_t HeldEvents::drop_older_half(std::string_view but) {
  HeldEvents kept;
  for (std::size_t i = 0; i < size(); ++i)
    if (const Event event = at(i); i >= size() / 2 || event.channel == but)
      kept.push(event.channel, event.data, event.timestamp_us);
  const auto dropped = static_cast<std::int64_t>(size() - kept.size());
  *this = std::move(kept);
  return dropped;
}

HeldEvents::Event HeldEvents::at(std::size_t index) const {
  assert(index < places_.size());
  const Place& place = places_[index];
  const std::uint8_t* begin = bytes_.data() + place.offset;
  return {.channel = {reinterpret_cast<const char*>(begin), place.channel_bytes},
          .data = {begin + place.channel_bytes, place.data_bytes},
          .timestamp_us = place.timestamp_us};
}

}  // namespace roadbalance
