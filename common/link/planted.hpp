#pragma once

namespace roadbalance {

/// Faults that can be planted into a build for tests, to prove that the checker finds them.  In every other
/// build planted() is constant false and the compiler takes the faulty branch away.
enum class PlantedFault {
  kNone,
  kFreeOnReceive,     ///< the node frees what arrived, durable or not
  kEpochReused,       ///< a node takes the epoch of its run before
  kNoHeartbeat,       ///< nothing reports a lost tail to the recorder
  kNoDeduplication,   ///< a block that came twice is recorded twice
  kOverwriteOldest,   ///< a full ring drops its oldest blocks
  kAckBeforeSync,     ///< called durable when written
  kSilentRingFull,    ///< scans that found no room leave no gap
  kGapOffByOne,       ///< a gap covers one scan more than it declares
  kNoCrashGap,        ///< the end of a crashed node is not declared
  kStaleRecorder,     ///< a node follows a recorder of the past
  kNoFolderSync,      ///< the name of a new segment is not on the disk when its blocks are called durable
  kTornTailKept,      ///< a torn tail is written on
  kRetryFailedSync,   ///< a sync that failed is tried again on the same file and believed
  kLostDeclaredLate,  ///< blocks that are gone at the node are passed over without a gap
  kBlocksSwapped,     ///< two neighbours change places and numbers
  kBlockAltered,      ///< a sample changes between seal and disk, with a good CRC
  kOneTooManyLost,    ///< a gap takes in the first block that its node still holds
};

#ifdef RB_PLANTED_FAULTS
inline PlantedFault planted_fault = PlantedFault::kNone;
inline bool planted(PlantedFault fault) {
  return planted_fault == fault;
}
#else
constexpr bool planted(PlantedFault) {
  return false;
}
#endif

}  // namespace roadbalance
