#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "common/record/header_check.hpp"

namespace roadbalance {

/// The events of the segment being written, as bytes: those that wait for a write(2), and the sum of the
/// headers that the next commit event carries.
struct SegmentEvents {
  std::vector<std::uint8_t> buffer;
  std::uint64_t segment_bytes = 0;  ///< of the segment: written, and in `buffer`
  std::int64_t event_number = 0;
  std::int64_t last_timestamp_us = 0;
  HeaderSum headers;  ///< since the last commit

  void put(std::string_view channel, std::span<const std::uint8_t> data);
  void put_commit(std::uint64_t durable_bytes);
  /// For the headers behind the last one, if there are any.
  void put_last_commit(std::uint64_t durable_bytes);
};

/// Bytes of a commit event.
std::uint64_t commit_event_bytes();

}  // namespace roadbalance
