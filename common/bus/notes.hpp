#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/frontend/device_report.hpp"
#include "common/frontend/front_end.hpp"

namespace roadbalance {

/// What the recorder writes into the record about itself; fields as in common/wire.

/// What a node says that it lost or had to mend, in its epoch so far; fields as in its heartbeats.
struct NodeLosses {
  std::int64_t repaired = 0;
  std::int64_t spool_failures = 0;
  std::int64_t scans_refused = 0;
  std::int64_t blocks_unsent = 0;
  std::int64_t acks_refused = 0;
  std::array<std::int64_t, 2> encoder_faults{};
  std::int64_t unreferenced_blocks = 0;
  std::array<std::int64_t, kDeviceCounters> device_counts{};  ///< [DeviceCounter]

  /// Counts of an epoch only rise; what says less was said earlier, or by someone who had heard less.
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
  kExcerpt = 19,  ///< this recording is made of another one (part of it; factor); text: which, and of what
  /// These are samples of another program, and times of notes (host_ns) are those of the samples; text: which
  /// file
  kImported = 20,
  kAlarmBegan = 21,    ///< (AlarmCause; place_number() of common/bus/alarm.hpp); text: how much
  kAlarmEnded = 22,    ///< the same, once it is over; text: how long it lasted
  kExcerptEpoch = 23,  ///< of an excerpt: an epoch of it (a) is made of one of the original (b)
  kLast = kExcerptEpoch
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

/// A failure of neither an errno nor a segment: of the recording that this one was made of something was
/// lost, or lies in another folder, that no gap can stand for; text: what and where.  Of a kind that every
/// reader knows.
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
  std::uint32_t headers_crc32c = 0;  ///< of the headers and channels from there up to this event
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
