#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace roadbalance {

inline constexpr const char* kRecordingChannel = "RB_RECORDING";
inline constexpr std::size_t kMostReceiptNodes = 8, kMostReceiptMarks = 6;
inline constexpr std::int32_t kMostRecordings = 64;  ///< that are reported, the newest

enum class RecordingState : std::int32_t {
  kNotRead = 0,     ///< waits for its receipt
  kGrowing = 1,     ///< a recorder writes to it
  kComplete = 2,    ///< every sample between start and stop is there, unaltered, once
  kIncomplete = 3,  ///< what is missing is declared, or an epoch has no end
  kDamaged = 4,     ///< something is missing or altered and nothing declares it
  kUnreadable = 5,
};

/// A recording and its receipt; fields as in common/wire/recording_t.
struct RecordingSummary {
  struct Node {
    std::int32_t node = 0;
    std::int64_t samples = 0, samples_lost = 0, repaired = 0;
    double seconds = 0, overload_s = 0;
    double sync_residual_s = -1;  ///< negative: no clock
    bool absent = false;          ///< for a time, or never there
  };
  struct Mark {
    std::int64_t time_us = 0;
    std::string text;         ///< cut after 48 bytes
    std::int32_t number = 0;  ///< as rb select counts them
  };
  std::int32_t number = 0, recordings = 0;
  std::string name{}, vehicle{};
  std::string place{};  ///< folder that it lies in
  RecordingState state = RecordingState::kNotRead;
  std::int64_t first_us = 0, last_us = 0, bytes = 0, refused = 0, damaged_bytes = 0;
  double rate_hz = 0, cutoff_hz = 0;  ///< 0: not known
  std::int32_t most_reduction = 0;    ///< 0: not known
  std::vector<Node> node{};           ///< the first kMostReceiptNodes are reported
  std::vector<Mark> mark{};           ///< the first kMostReceiptMarks are reported with their texts
  std::int32_t marks = 0;
  std::string verdict{};  ///< cut after 160 bytes
};

std::vector<std::uint8_t> encode(const RecordingSummary& receipt);
std::optional<RecordingSummary> decode_recording(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
