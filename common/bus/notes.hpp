#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/types/device_report.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

/// Messages that the recorder writes into the record about itself; fields as in common/wire.

/// Losses and repairs that a node reports, in its epoch so far; fields as in its heartbeats.
struct NodeLosses {
  std::int64_t repaired = 0;
  std::int64_t spool_failures = 0;
  std::int64_t scans_refused = 0;
  std::int64_t blocks_unsent = 0;
  std::int64_t acks_refused = 0;
  std::array<std::int64_t, 2> encoder_faults{};
  std::int64_t unreferenced_blocks = 0;
  std::array<std::int64_t, kDeviceCounters> device_counts{};  ///< [DeviceCounter]

  /// Calls field(name, of.field...) for each field in order, of one or of several that have the same: a count
  /// or an array of counts.
  template <typename Field, typename... Losses>
  static void list(const Field& field, Losses&... of) {
    field("repaired", of.repaired...);
    field("spool_failures", of.spool_failures...);
    field("scans_refused", of.scans_refused...);
    field("blocks_unsent", of.blocks_unsent...);
    field("acks_refused", of.acks_refused...);
    field("encoder_faults", of.encoder_faults...);
    field("unreferenced_blocks", of.unreferenced_blocks...);
    field("device_counts", of.device_counts...);
  }
  /// The same for each single count.
  template <typename Count, typename... Losses>
  static void list_counts(const Count& count, Losses&... of) {
    const auto field = [&count](const char* name, auto& first, auto&... others) {
      if constexpr (requires { first.size(); })
        for (std::size_t k = 0; k < first.size(); ++k) count(name, first[k], others[k]...);
      else
        count(name, first, others...);
    };
    list(field, of...);
  }

  /// Counts of an epoch only rise; a report of less is an earlier one, or comes from someone who had heard
  /// less.
  void raise(const NodeLosses& said);
  bool operator==(const NodeLosses&) const = default;
};

struct Journal {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t time_us = 0;
  std::int64_t first_sequence = 1;
  std::int64_t last_sequence = 0;
  std::int64_t first_scan = 0;
  std::int64_t next_scan = 0;
  std::int64_t scans = 0;
  std::int64_t scans_missing = 0;
  std::array<std::uint32_t, kChannels> channel_crc{};
  NodeLosses node_losses{};
  std::int64_t refused = 0;
  std::int64_t rivals = 0;
  std::int64_t unsent = 0;
  std::int64_t disk_failures = 0;
};

/// note_t.kind; in brackets what a and b are.
enum class NoteKind : std::int32_t {
  kStarted = 1,           ///< the recorder runs (segment it begins with)
  kStopped = 2,           ///< it ends as asked (node epochs of the record; last mark of this run)
  kClock = 3,             ///< the pair of clocks alone, every ten seconds
  kDiskFailed = 4,        ///< a write or sync failed (errno; segment), or tells_of_loss()
  kSegmentAbandoned = 5,  ///< the segment (a) ends at byte (b), whatever lies behind: it could not be cut
  kDiskFull = 6,          ///< recording waits for space (bytes free)
  kDiskFree = 7,          ///< recording goes on (bytes free)
  kFallback = 8,          ///< another folder is used from here on; text: which
  kPowerLost = 9,         ///< the supply is gone; text: which
  kPowerReturned = 10,
  kSegmentDeleted = 11,  ///< by the retention mode (segment; bytes)
  kTailCut = 12,  ///< at the start: bytes behind the last event were cut (segment; bytes) and kept beside it
  kDiskLow = 13,  ///< at the present rate (seconds left; bytes free)
  kPowerUnknown = 14,    ///< the supply cannot be read (1), or can be again (0); text: which
  kDevice = 15,          ///< devices of a node (a) have counted something (b: DeviceCounter); text: what
  kEndContradicts = 16,  ///< the blocks received of a node (a) are not those that its end (block b) sums up
  kMark = 17,            ///< somebody set a mark (its number in this recording); text: what he said
  kAsked = 18,           ///< somebody asked for something (Operation; RefusalReason); text: what became of it
  kSubset = 19,  ///< this recording is made of another one (part of it; factor); text: which, and of what
  /// These are samples of another program, and times of notes (host_ns) are those of the samples; text: which
  /// file
  kImported = 20,
  kAlarmBegan = 21,   ///< (AlarmCause; place_number() of common/bus/alarm.hpp); text: how much
  kAlarmEnded = 22,   ///< the same, once it is over; text: how long it lasted
  kSubsetEpoch = 23,  ///< of a subset: an epoch of it (a) is made of one of the original (b)
  kNodeMissing =
      24,  ///< a node (a) does not measure though the recording goes on (AbsenceCause); text: its name
  kNodeThere = 25,  ///< it measures (again); b: 1 if samples lack because of that, 0 if it only was not heard
  kStopping = 26,   ///< the recording is to end: from here on no node is missed; text: by whom
  kClockSet = 27,   ///< the wall clock was set (by so many us): UTC of before is so much later
  kSlept = 28,      ///< the computer was suspended (for so many us)
  kLast = kSlept
};

struct Note {
  std::int64_t time_us = 0;
  std::int64_t host_ns = 0;
  std::int64_t incarnation = 0;
  NoteKind kind = NoteKind::kStarted;
  std::int64_t a = 0;
  std::int64_t b = 0;
  std::string text;  ///< cut after kMaxNoteBytes
};
inline constexpr std::size_t kMaxNoteBytes = 400;

/// A failure of neither an errno nor a segment: something of the recording that this one was made of was
/// lost, or lies in another folder, and no gap can stand for it; text: what and where.  Every reader reads
/// this kind.
inline Note note_of_loss(std::string text) {
  return {.kind = NoteKind::kDiskFailed, .text = std::move(text)};
}
inline bool tells_of_loss(const Note& note) {
  return note.kind == NoteKind::kDiskFailed && note.a == 0 && note.b == 0;
}

/// After each sync: so many bytes of the segment it stands in are on the disk, so that damage among them is
/// no torn tail; and the headers of the events since the commit before.
struct Commit {
  std::int64_t bytes = 0;
  std::int64_t headers_from = 0;     ///< offset of the commit before; 0: of the segment
  std::uint32_t headers_crc32c = 0;  ///< of the events from there up to this one: see commit_t.lcm
};

inline constexpr const char* kJournalChannel = "RB_JOURNAL";
inline constexpr const char* kNoteChannel = "RB_NOTE";
inline constexpr const char* kCommitChannel = "RB_COMMIT";

/// Decoding refuses wrong size, type, CRC or bounds.
std::vector<std::uint8_t> encode(const Journal& journal);
std::vector<std::uint8_t> encode(const Note& note);
std::vector<std::uint8_t> encode(const Commit& commit);
std::optional<Journal> decode_journal(std::span<const std::uint8_t> bytes);
std::optional<Note> decode_note(std::span<const std::uint8_t> bytes);
std::optional<Commit> decode_commit(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
