#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace roadbalance {

/// The kinds of block that share one sequence per node epoch.
enum class BlockKind : std::uint8_t { kScan, kEdge, kGap, kMeta, kEnd, kSignal };
inline constexpr std::size_t kBlockKinds = 6;

/// Possible faults of a scan block; bits of scan_block_t.quality.  Above them: angle_sigma.hpp.
enum Quality : std::int32_t {
  kQualityOverload = 1 << 0,         ///< a channel left its range
  kQualityNoReference0 = 1 << 1,     ///< the angle of the wheel on line 0 is not known; its references are 0
  kQualityNoReference1 = 1 << 2,     ///< the same for line 1
  kQualityUncertainAngle0 = 1 << 3,  ///< a turn of the wheel on line 0 did not have exactly its teeth
  kQualityUncertainAngle1 = 1 << 4,  ///< the same for line 1
  kQualityAfterGap = 1 << 5,         ///< first block after lost scans: filters restart here
};

inline constexpr int kQualityBits = 6;
inline constexpr std::int32_t kQualityFlags = (1 << kQualityBits) - 1;

/// The bit for that of the wheel on `line`, 0 or 1.
constexpr std::int32_t quality_no_reference(int line) {
  return kQualityNoReference0 << line;
}

/// Why scans are not in the record; gap_t.cause.  A device that fails needs none: its epoch ends with it.
enum class GapCause : std::int32_t {
  kRingFull = 1,       ///< the node could not keep them: recorder away for too long
  kDeviceOverrun = 2,  ///< the device lost them before the node read it
  kLostAtNode = 4,     ///< the node no longer had the block when it was asked for
  kNodeCrash = 5,      ///< the epoch has no end: its length is unknown
  kSourceGap = 6,      ///< imported data had no sample of the node here
  kLostInRecord = 7,   ///< was damaged in the record or missing there when it was recovered
  kDeviceGone = 8,     ///< the device was not there: unplugged, its bus down
  kStartedLate = 9,    ///< the node heard of the start behind its instant
  kSlept = 10,         ///< the node's computer was suspended
};

/// A gap of this cause stands for every block since the one before it and bears the number of the last;
/// every other gap stands for itself alone.
constexpr bool stands_for_lost_blocks(GapCause cause) {
  return cause == GapCause::kLostAtNode || cause == GapCause::kLostInRecord;
}

/// A gap of this cause is declared by who has the record; every other is a block that its node sealed.
constexpr bool is_declared_by_host(GapCause cause) {
  return stands_for_lost_blocks(cause) || cause == GapCause::kNodeCrash;
}

enum class MetaKind : std::int32_t { kVehicleToml = 1, kRecordJson = 2 };
enum class NodeState : std::int32_t { kPreview = 0, kStarted = 1, kEnded = 2, kFailed = 3 };
/// Why a node does not measure, or does not any more.  Up to kProgramEnded the node reports it itself
/// (heartbeat_t.end_cause); those behind are its recorder's.
enum class AbsenceCause : std::int32_t {
  kNone = 0,        ///< it measures
  kStopped = 1,     ///< by a command
  kSourceOver = 2,  ///< its source has no more: a simulated drive, a file
  kDeviceFailed = 3,
  kProgramEnded = 4,  ///< asked to: by its service, a person, a closed terminal
  kSilent = 5,        ///< it is not heard
  kNeverCame = 6,     ///< it has not been heard since the recording began
};
/// The kind of a node's clock; heartbeat_t.time_base.
enum class TimeBase : std::int32_t {
  kOwn = 0,     ///< the node's own oscillator: related to the host's by exchanges of stamps
  kShared = 1,  ///< one time for all nodes by construction: a simulation faster than real time, an import
};
enum class Verb : std::int32_t { kClaim = 1, kRelease = 2, kStart = 3, kStop = 4, kConfigure = 5 };
enum class CommandError : std::int32_t {
  kNone = 0,
  kNotOwner = 1,
  kUnknownVerb = 2,
  kEnded = 3,           ///< the epoch is over
  kMeasuring = 4,       ///< not between start and end: an epoch has one vehicle.toml
  kVehicleMissing = 5,  ///< parts of the vehicle.toml have not arrived: send them again
  kVehicleRefused = 6,  ///< the node cannot measure by it; reply_t.text holds why
};

inline constexpr std::int32_t kLastNode = 9999;  ///< nodes are numbered from 1; 0 is the host
inline constexpr std::size_t kMostNodes = 64;    ///< recorded at a time; more are refused
/// No sequence, scan index or count from outside is larger: sums and differences of these do not overflow.
inline constexpr std::int64_t kIndexLimit = std::int64_t{1} << 48;
inline constexpr bool is_index(std::int64_t value) {
  return 0 <= value && value <= kIndexLimit;
}
/// The same for node clocks, in nanoseconds either way from their zero: 73 years.
inline constexpr std::int64_t kClockLimit_ns = std::int64_t{1} << 61;
inline std::int64_t bounded_ns(std::int64_t time_ns) {
  return std::clamp(time_ns, -kClockLimit_ns, kClockLimit_ns);
}

/// The fields every block begins with; see common/wire for their meaning.
struct BlockHeader {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t sequence = 0;
  std::int64_t first_scan = 0;
  std::int64_t scans = 0;
  std::int64_t time_ns = 0;

  bool operator==(const BlockHeader&) const = default;
};

/// One datagram must hold a block, so that a lost fragment cannot take another with it.
inline constexpr std::size_t kMaxBlockBytes = 1400;

/// A block as it travels and as it is recorded: the encoded LCM message, never changed after sealing.
struct SealedBlock {
  BlockKind kind = BlockKind::kScan;
  BlockHeader header;
  std::uint32_t size = 0;
  std::array<std::uint8_t, kMaxBlockBytes> storage{};

  std::span<const std::uint8_t> bytes() const { return {storage.data(), size}; }
};

}  // namespace roadbalance
