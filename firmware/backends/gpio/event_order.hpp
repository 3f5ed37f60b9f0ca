#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/backends/gpio/input_event.hpp"

namespace roadbalance {

/// Brings events of several inputs, each read in its own order, into one order of time: holds them until
/// nothing older can come.  Never allocates after construction.
class EventOrder {
 public:
  explicit EventOrder(std::size_t capacity) : events_(capacity) {}

  std::size_t room() const noexcept { return events_.size() - held_; }
  /// Needs room.  False, and it is not taken, if it is older than one that was given back: too late.
  [[nodiscard]] bool add(const InputEvent& event) noexcept;
  /// The oldest, if it is older than `until_ns`.
  std::optional<InputEvent> take_before(std::int64_t until_ns) noexcept;

 private:
  std::vector<InputEvent> events_;  ///< the youngest first, so that the oldest goes without moving the rest
  std::size_t held_ = 0;
  std::int64_t given_ns_ = INT64_MIN;
};

}  // namespace roadbalance
