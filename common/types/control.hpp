#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/types/block.hpp"
#include "common/types/device_report.hpp"

namespace roadbalance {

/// The small messages that flow back, and the heartbeat; fields as in common/wire.

struct Heartbeat {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t base = 1;
  std::int64_t next = 1;
  std::int64_t time_ns = 0;
  NodeState state = NodeState::kPreview;
  std::int64_t owner = 0;
  std::int64_t ring_used = 0;
  std::int64_t ring_capacity = 0;
  std::int64_t spool_used = 0;
  std::int64_t spool_failures = 0;
  std::int64_t scans_sampled = 0;
  std::int64_t scans_missing = 0;
  std::int64_t scans_refused = 0;
  std::int64_t blocks_sent = 0;
  std::int64_t blocks_repaired = 0;
  std::int64_t blocks_unsent = 0;
  std::int64_t acks_refused = 0;
  std::array<std::int64_t, 2> encoder_faults{};
  std::array<std::int32_t, 4> mark_counts{};  ///< [2 line + k]
  std::int64_t unreferenced_blocks = 0;
  std::array<std::int64_t, kDeviceCounters> device_counts{};  ///< [DeviceCounter]
  TimeBase time_base = TimeBase::kOwn;
  std::uint32_t clock_address = 0;  ///< IPv4, as a number
  std::uint16_t clock_port = 0;
  std::uint32_t vehicle_crc32c = 0;
  AbsenceCause end_cause = AbsenceCause::kNone;

  /// Nothing more is sealed.
  bool is_over() const { return state == NodeState::kEnded || state == NodeState::kFailed; }
};

struct SequenceRange {
  std::int64_t first = 0;
  std::int64_t last = 0;
  bool operator==(const SequenceRange&) const = default;
};
inline constexpr std::size_t kMaxMissingRanges = 32;

struct Ack {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t incarnation = 0;
  std::int64_t number = 0;
  std::int64_t received = 0;
  std::int64_t durable = 0;
  std::int64_t credit = 0;
  std::vector<SequenceRange> missing;  ///< at most kMaxMissingRanges, ascending
};

struct Command {
  std::int32_t node = 0;
  std::int64_t request = 0;
  std::int64_t incarnation = 0;
  Verb verb = Verb::kClaim;
  std::int64_t epoch = 0;
  std::int64_t delay_us = 0;
  std::uint32_t vehicle_crc32c = 0;
};
/// A delay is no longer, either way.
inline constexpr std::int64_t kLongestDelay_us = 3'600'000'000;

struct Reply {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t request = 0;
  CommandError result = CommandError::kNone;
  std::int64_t sequence = 0;
  std::string text{};  ///< cut after 300 bytes
};

/// vehicle_t.
struct VehiclePart {
  std::int32_t node = 0;
  std::int64_t incarnation = 0;
  std::uint32_t vehicle_crc32c = 0;
  std::int32_t part = 0;
  std::int32_t parts = 0;
  std::string text{};  ///< at most kMostVehiclePart bytes
};
inline constexpr std::size_t kMostVehiclePart = 1200;
inline constexpr std::size_t kMostVehicleParts = 256;

}  // namespace roadbalance
