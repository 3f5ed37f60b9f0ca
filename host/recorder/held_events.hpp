#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace roadbalance {

/// The events that the record has been given since it was last durable, in order: after a failed write or
/// sync they are written again, so that nothing hangs on the nodes still having them.
///
/// Bounded by what the nodes' credit lets arrive; memory once used is kept.
class HeldEvents {
 public:
  struct Event {
    std::string_view channel;
    std::span<const std::uint8_t> data;
    std::int64_t timestamp_us = 0;
  };

  void push(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t timestamp_us);
  void clear();
  /// Forgets the older half but for those on the channel `but`.  @return how many
  std::int64_t drop_older_half(std::string_view but);

  std::size_t size() const { return places_.size(); }
  std::size_t bytes() const { return bytes_.size(); }
  /// Valid until the next push or clear.
  Event at(std::size_t index) const;

 private:
  struct Place {
    std::size_t offset = 0;
    std::size_t channel_bytes = 0;
    std::size_t data_bytes = 0;
    std::int64_t timestamp_us = 0;
  };
  std::vector<std::uint8_t> bytes_;
  std::vector<Place> places_;
};

}  // namespace roadbalance
