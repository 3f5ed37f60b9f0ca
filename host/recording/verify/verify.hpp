#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/record/disk.hpp"
#include "host/recording/recorded_alarms.hpp"
#include "host/recording/verify/verify_epochs.hpp"

namespace roadbalance {

enum class Verdict : int {
  kComplete = 0,    ///< every scan between start and stop is there, unaltered, once
  kDamaged = 1,     ///< something is missing or altered, undeclared
  kIncomplete = 3,  ///< what is missing is declared, or an epoch has no end (yet)
  kUnreadable = 4,
};

struct Verification {
  Verdict verdict = Verdict::kUnreadable;  ///< its value is the exit code
  std::string error;                       ///< why unreadable
  std::vector<VerifiedEpoch> epoch;        ///< by node, then in order of appearance
  std::int64_t events = 0;
  std::int64_t blocks_refused = 0;   ///< altered: events on block channels that are no good block of theirs
  std::int64_t entries_refused = 0;  ///< the same of journal entries, notes, commits and clocks
  std::int64_t journal_entries = 0;  ///< compared with the blocks
  /// Events of ours on other channels, or of a newer release: only their CRC is checked.
  std::int64_t other_events = 0;
  std::int64_t deleted_segments = 0;  ///< by the retention mode, according to notes; a kill may repeat one
  std::uint64_t damaged_bytes = 0;    ///< bytes that are no events
  /// Stretches between two commits in which an event contradicts the second commit: its number, stamp or
  /// channel, or its contents.
  std::int64_t altered_headers = 0;
  std::int64_t missing_segments = 0;  ///< absent, empty, or changed since they were finished
  /// At the end of an unfinished last segment: a kill leaves such a tail; it was never acknowledged.
  std::uint64_t torn_bytes = 0;
  std::vector<std::string> damage;  ///< where, for people
  /// Losses that are declared, but by no gap, for people: segments that the retention mode deleted, bytes
  /// that rb recover could not read, blocks that a recorder held when it stopped.
  std::vector<std::string> lost;
  /// Nodes that did not measure from start to stop though they should.
  struct Absent {
    std::int32_t node = 0;
    std::string text{};  ///< for people: "node 2 (rear) never came"
  };
  std::vector<Absent> absent;
  std::vector<std::string> elsewhere;  ///< parts of the recording that are in other folders, for people
  std::vector<std::string> not_read;   ///< what lies in the folder and is no regular file, for people
  std::vector<std::string> notes;      ///< of the recorder, for people
  RecordedAlarms alarms;               ///< that it noted
  std::vector<std::string> indexes;    ///< that contradict their segments; they can be made again,
                                       ///< but for one that lists more than its segment has
};

/// Reads a whole recording and reports what it proves.  Content of the folder never makes it throw.  Bytes
/// behind the end of an abandoned segment do not count.
Verification verify_record(const std::filesystem::path& folder, Disk& disk = kernel_disk());

/// The verdict in words, as far as the record proves it: "incomplete: node 2 (rear) never came" where a node
/// was absent, "incomplete, every gap declared", "what is lost
/// is listed" where no gap can stand for it, or "no end: what came after is unknown" for an open epoch.
std::string verdict_text(const Verification& result);

/// A note in words: its time, what happened, and its text.
std::string note_text(const Note& note);

}  // namespace roadbalance
