#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/types/block.hpp"

namespace roadbalance {

enum class RecorderState : std::int32_t {
  kRecording = 1,
  kDiskFailing = 2,  ///< no credit: the disk refuses; it goes on trying and the nodes keep everything
  kDiskFull = 3,     ///< no credit: it waits for space
  kStopping = 4,
  kIdle = 5,   ///< nothing is recorded, and none of the nodes that would be is there
  kArmed = 6,  ///< nothing is recorded; a start would record the nodes that are there
  kFault = 7,  ///< a recording should be under way and is not; fault: why
};

/// It does not measure though it should.
struct AbsentNode {
  std::int32_t node = 0;
  AbsenceCause cause = AbsenceCause::kNone;
  bool operator==(const AbsentNode&) const = default;
};
inline constexpr std::size_t kMostAbsentNamed = 16;

/// recorder_t; fields as in common/wire.
struct RecorderStatus {
  std::int64_t time_us = 0;
  std::int64_t recorder = 0;
  std::int64_t incarnation = 0;
  RecorderState state = RecorderState::kRecording;
  bool on_battery = false;
  bool power_unknown = false;  ///< the supply is watched and cannot be read
  bool fallback = false;
  std::int32_t segment = 0;
  std::int64_t bytes_recorded = 0;
  std::int64_t bytes_free = 0;
  double seconds_left = -1;
  double sync_s = 0;
  double longest_sync_s = 0;
  std::int64_t waiting_blocks = 0;
  std::int64_t disk_failures = 0;
  std::int64_t segments_deleted = 0;
  std::int64_t refused_datagrams = 0;
  std::array<std::int64_t, 5> refused_blocks{};
  std::int64_t rivals = 0;
  std::int64_t unsent = 0;
  double recording_s = 0;
  std::int32_t nodes = 0;
  std::int32_t marks = 0;
  std::vector<AbsentNode> absent{};  ///< the first kMostAbsentNamed are sent
  std::int32_t left_out = 0;
  bool operable = false;  ///< takes requests
  std::string name{};     ///< of the recording
  std::string fault{};
};

inline constexpr const char* kRecorderChannel = "RB_RECORDER";

/// Decoding refuses wrong size, type, CRC or bounds.
std::vector<std::uint8_t> encode(const RecorderStatus& status);
std::optional<RecorderStatus> decode_recorder_status(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
