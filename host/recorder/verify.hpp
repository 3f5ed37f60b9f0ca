#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/record/disk.hpp"
#include "host/recorder/recorded_alarms.hpp"
#include "host/recorder/verify_epochs.hpp"

namespace roadbalance {

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
  std::int64_t blocks_refused = 0;   ///< events on block channels that are no good block of it: altered
  std::int64_t entries_refused = 0;  ///< the same of journal entries, notes, commits and clocks
  std::int64_t journal_entries = 0;  ///< compared with the blocks
  /// No more than their CRC is looked at, of ours: on other channels, or what a newer release alone can read.
  std::int64_t other_events = 0;
  std::int64_t deleted_segments = 0;  ///< by the retention mode, as notes say, of which a kill may repeat one
  std::uint64_t damaged_bytes = 0;    ///< no events
  /// Stretches between two commits in which a number, stamp or channel is not what the second one says.
  std::int64_t altered_headers = 0;
  std::int64_t missing_segments = 0;  ///< not there, empty or other than when they were finished
  /// At the end of the last segment, if that is not finished: what a kill leaves, never acknowledged.
  std::uint64_t torn_bytes = 0;
  std::vector<std::string> damage;  ///< where, for people
  /// What is declared lost, but by no gap, for people: segments that the retention mode deleted, what rb
  /// recover could not read, what a recorder held when it stopped.
  std::vector<std::string> lost;
  std::vector<std::string> elsewhere;  ///< parts of the recording that are in other folders, for people
  std::vector<std::string> notes;      ///< what the recorder noted, for people
  RecordedAlarms alarms;               ///< that it noted
  std::vector<std::string> indexes;  ///< that say something else than their segments; they can be made again,
                                     ///< but for one that knows of more than its segment has
};

/// Reads a whole recording and says what it proves.  Never throws for what is in the folder.  What lies
/// behind the end of an abandoned segment does not count.
Verification verify_record(const std::filesystem::path& folder, Disk& disk = kernel_disk());

/// The verdict in words, as far as the record proves it: "incomplete, every gap declared", "what is lost
/// is listed" where no gap can, or "no end: what came after is unknown" where an epoch is open.
std::string verdict_text(const Verification& result);

/// A note in words: its time, what happened, and its text.
std::string note_text(const Note& note);

}  // namespace roadbalance
