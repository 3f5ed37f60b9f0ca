#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "common/bus/codec.hpp"

namespace roadbalance {

/// One event of an LCM event log: sync word 0xEDA1DA01, number, microseconds, channel, payload.
struct LogEvent {
  std::int64_t number = 0;
  std::int64_t timestamp_us = 0;
  std::string_view channel;
  std::span<const std::uint8_t> data;
  bool has_its_crc = false;  ///< known to end with its CRC, as the readers of records find out
};

/// As accept() of its bytes (common/bus/codec.hpp).
inline Refusal accept(const LogEvent& event, SealedBlock& out) {
  return accept(event.data, out, event.has_its_crc);
}

/// The bytes of one event of an LCM event log: sync word, number, microseconds, length of the channel name,
/// length of the data (all big endian), the name, the data.
/// Source: LCM 1.3.1, lcm/eventlog.c.
inline constexpr std::uint32_t kLogSync = 0xEDA1DA01;
inline constexpr std::size_t kLogHeaderBytes = 28;
inline constexpr std::size_t kMaxLogChannelBytes = 63;  ///< LCM_MAX_CHANNEL_NAME_LENGTH
inline constexpr std::size_t kMaxLogDataBytes = 1 << 16;
inline constexpr std::size_t kMaxLogEventBytes = kLogHeaderBytes + kMaxLogChannelBytes + kMaxLogDataBytes;

std::array<std::uint8_t, kLogHeaderBytes> encode_log_header(const LogEvent& event);

struct ParsedEvent {
  enum class Status {
    kEvent,       ///< `event` and `bytes` are good
    kIncomplete,  ///< what is there may be the beginning of an event
    kInvalid,     ///< no event begins here
  };
  Status status = Status::kInvalid;
  LogEvent event;         ///< views into the given bytes
  std::size_t bytes = 0;  ///< length of the event
};

/// Takes the event that begins at bytes[0], or reports that none does.  Lengths are bounded and the channel
/// name is printable, so that few byte strings pass by accident.
ParsedEvent parse_log_event(std::span<const std::uint8_t> bytes);

/// True if `bytes` begins with the sync word, or is shorter and begins like it.
bool may_begin_event(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
