#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/record/record_state.hpp"
#include "common/types/block.hpp"
#include "common/types/blocks.hpp"
#include "host/recording/verify/block_runs.hpp"

namespace roadbalance {

/// Consecutive block numbers, or scans, that are missing.
struct MissingSpan {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

/// A declared gap.
struct VerifiedGap {
  GapCause cause = GapCause::kRingFull;
  std::int64_t first_block =
      0;                      ///< the first of the blocks it stands for; `sequence` if it stands for itself
  std::int64_t sequence = 0;  ///< its own number: that of the last of them
  std::int64_t first_scan = 0;
  std::int64_t scans = 0;     ///< 0 for a crash, or if unknown
  bool has_no_scans = false;  ///< 0 is certain: the scans behind it go on where it begins
};

/// One node epoch as a record holds it.
struct VerifiedEpoch {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t blocks = 0;
  std::int64_t last_sequence = 0;
  std::int64_t samples = 0;          ///< scans in recorded blocks
  std::int64_t samples_missing = 0;  ///< scans in declared gaps
  /// Scans, recorded or declared missing, in segments that were deleted, or in the folder that this one
  /// continues.
  std::int64_t samples_deleted = 0;
  bool ended = false;             ///< the node's end block is there
  std::int64_t samples_sent = 0;  ///< by the node's end; without one, as recorded
  std::int64_t period_ps = 0;     ///< of the scan blocks
  std::vector<VerifiedGap> gaps;
  std::vector<MissingSpan> undeclared_blocks;
  std::vector<MissingSpan> undeclared_scans;
  std::int64_t repeated_blocks = 0;         ///< copies of a block that is there already
  std::int64_t contradicting_blocks = 0;    ///< other blocks under a number that is there already
  std::int64_t overlapping_blocks = 0;      ///< with scans that an earlier block has, too
  std::vector<std::string> contradictions;  ///< between the end's totals, or the journal, and the blocks
  NodeLosses losses;                        ///< as the journal counts them

  bool is_damaged() const {
    return !undeclared_blocks.empty() || !undeclared_scans.empty() || repeated_blocks > 0 ||
           contradicting_blocks > 0 || overlapping_blocks > 0 || !contradictions.empty();
  }
  bool is_complete() const { return !is_damaged() && ended && gaps.empty() && samples_deleted == 0; }
  /// Neither the node's end nor a declared crash is there (yet): anything may have come after.
  bool is_open() const { return !ended && (gaps.empty() || gaps.back().cause != GapCause::kNodeCrash); }
};

/// Collects the blocks of a record and then reports on each node epoch.  Takes four bytes a block
/// (`BlockRuns`): 0.1 GB for a day of three nodes at 2 kHz.
class EpochCheck {
 public:
  /// Where the record begins, if its first segments were deleted.  May be called before or after the blocks:
  /// the notes on it stand among them.
  void begin_behind(const std::map<NodeEpoch, RecordState::Epoch>& deleted);
  /// In the record's order; no descriptions.
  void add(const SealedBlock& block);
  /// The blocks before the first one of each epoch are in another folder.
  void begin_anywhere() { begins_anywhere_ = true; }
  /// By node, then in order of appearance.
  std::vector<VerifiedEpoch> result();
  /// Number of epochs, those that ended in deleted segments included.
  std::size_t count() const { return epochs_.size(); }

 private:
  struct Epoch {
    RecordState::Epoch deleted;
    BlockRuns blocks;
    std::optional<EndBlock> end;
    std::int64_t period_ps = 0;
  };
  Epoch& find_or_add(NodeEpoch key);
  static bool covers_numbers_before(const BlockEntry& entry);
  static void check_sequence(const BlockEntry& entry, const BlockEntry* before, VerifiedEpoch& result);
  static void check_scans(const BlockEntry& entry, std::int64_t& next_scan, VerifiedEpoch& result);
  static void count(const BlockEntry& entry, std::int64_t first_block, VerifiedEpoch& result);
  static void prove_without_scans(const BlockEntry& entry, VerifiedEpoch& result);
  static void check_sum(const Epoch& epoch, VerifiedEpoch& result);
  static void check_totals(const Epoch& epoch, VerifiedEpoch& result);
  static VerifiedEpoch check(NodeEpoch key, Epoch& epoch);
  static void begin_at_its_first_block(Epoch& epoch);

  bool begins_anywhere_ = false;
  std::vector<std::pair<NodeEpoch, Epoch>> epochs_;  // in order of appearance: an epoch is a random number
};

}  // namespace roadbalance
