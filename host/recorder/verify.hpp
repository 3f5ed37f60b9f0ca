#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/link/block.hpp"

namespace roadbalance {

/// Consecutive block numbers, or scans, that are not there.
struct MissingSpan {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

/// A declared gap.
struct VerifiedGap {
  GapCause cause = GapCause::kRingFull;
  std::int64_t sequence = 0;
  std::int64_t first_scan = 0;
  std::int64_t scans = 0;  ///< 0 for a crash, or if unknown
};

/// What a record holds of one node epoch.
struct VerifiedEpoch {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t blocks = 0;
  std::int64_t last_sequence = 0;
  std::int64_t samples = 0;          ///< scans in recorded blocks
  std::int64_t samples_missing = 0;  ///< scans in declared gaps
  bool ended = false;                ///< the node's end is there
  std::int64_t samples_sent = 0;     ///< by the node's end; without one, as recorded
  std::vector<VerifiedGap> gaps;
  std::vector<MissingSpan> undeclared_blocks;
  std::vector<MissingSpan> undeclared_scans;
  std::int64_t repeated_blocks = 0;
  std::int64_t overlapping_blocks = 0;      ///< scans that an earlier block has too
  std::vector<std::string> contradictions;  ///< of the end's totals with what is there

  bool is_damaged() const {
    return !undeclared_blocks.empty() || !undeclared_scans.empty() || repeated_blocks > 0 ||
           overlapping_blocks > 0 || !contradictions.empty();
  }
  bool is_complete() const { return !is_damaged() && ended && gaps.empty(); }
  /// Neither the node's end nor a declared crash is there (yet): what came after is unknown.
  bool is_open() const { return !ended && (gaps.empty() || gaps.back().cause != GapCause::kNodeCrash); }
};

enum class Verdict : int {
  kComplete = 0,    ///< every scan between start and stop is there, unaltered, once
  kDamaged = 1,     ///< something is missing or altered and nothing declares it
  kIncomplete = 3,  ///< what is missing is declared, or an epoch has no end (yet)
  kUnreadable = 4,
};

struct Verification {
  Verdict verdict = Verdict::kUnreadable;  ///< its value is the exit code
  std::string error;                       ///< why unreadable
  std::vector<VerifiedEpoch> epoch;        ///< by node, then in order of appearance
  std::int64_t events = 0;
  std::int64_t blocks_refused = 0;    ///< events on block channels that are no good block of it: altered
  std::int64_t other_events = 0;      ///< on other channels: not looked at
  std::uint64_t damaged_bytes = 0;    ///< no events
  std::int64_t missing_segments = 0;  ///< not there, empty or shorter than when they were finished
  /// At the end of the last segment, if that is not finished: what a kill leaves, never acknowledged.
  std::uint64_t torn_bytes = 0;
  std::vector<std::string> damage;  ///< where, for people
};

/// Reads a whole recording and says what it proves.  Never throws for what is in the folder.
Verification verify_record(const std::filesystem::path& folder);

/// The verdict in words, as far as the record proves it: "incomplete, every gap declared", or "no end: what
/// came after is unknown" where an epoch is open.
std::string verdict_text(const Verification& result);

}  // namespace roadbalance
