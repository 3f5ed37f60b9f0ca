#include "host/recording/verify/verify.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/bus/absence.hpp"
#include "common/bus/alarm.hpp"
#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/types.hpp"
#include "common/clock/utc.hpp"
#include "common/record/folder.hpp"
#include "common/record/header_check.hpp"
#include "common/record/log_event.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/record_state.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "common/text/printable.hpp"
#include "common/types/bounded_time.hpp"
#include "host/recording/continued_folders.hpp"
#include "host/recording/foreign_log.hpp"
#include "host/recording/manifest.hpp"
#include "host/recording/set_clocks.hpp"
#include "host/recording/verify/verify_journal.hpp"
#include "host/recording/verify/verify_missing.hpp"
#include "host/recording/verify/verify_presence.hpp"

namespace roadbalance {
namespace {

struct Reading {
  Verification& result;
  bool is_all = true;  // of its recording: no other folder holds what comes before, no segment was deleted
  bool is_begin_known = true;  // without a good index nothing can be compared with the place where it begins
  EpochCheck epochs{};
  JournalCheck journal{};
  PresenceCheck presence{};
  SetClocks clocks{};
  std::vector<std::pair<Note, SetClocks::Stamp>> notes{};  // but the pairs of clocks
  HeaderCheck headers{};
  SealedBlock block{};      // the last; here, since making one clears all it holds
  std::set<int> deleted{};  // segments, by the notes
  std::int64_t last_mark = 0;
  std::int64_t epochs_noted = 0, marks_noted = 0;  // by the notes of recorders that stopped
};

void list_missing_segments(const std::filesystem::path& folder, const FinishedSegments& finished, Disk& disk,
                           Reading& reading) {
  const MissingSegments found = find_missing_segments(folder, finished, reading.deleted, disk);
  reading.result.missing_segments += found.missing;
  reading.result.damage.insert(reading.result.damage.end(), found.lines.begin(), found.lines.end());
  for (const SegmentRun run : found.deleted)
    reading.result.lost.push_back(in_words(run) + (run.first == run.last ? " was" : " were") +
                                  " deleted by the retention mode");
}

void compare_with_stops(Reading& reading) {
  if (!reading.is_all) return;
  const auto epochs = static_cast<std::int64_t>(reading.epochs.count());
  const std::string stopped = "the recorder stopped with ";
  if (reading.epochs_noted > epochs)
    reading.result.lost.push_back(stopped + std::to_string(reading.epochs_noted) + " node epochs; here are " +
                                  std::to_string(epochs));
  if (reading.marks_noted > reading.last_mark)
    reading.result.lost.push_back(stopped + "mark " + std::to_string(reading.marks_noted) +
                                  " set; the last one here is " + std::to_string(reading.last_mark));
}

std::string place(const std::filesystem::path& segment, std::uint64_t bytes, std::uint64_t offset) {
  return segment.filename().string() + ": " + std::to_string(bytes) + " bytes from " +
         std::to_string(offset) + " on ";
}

void list_damage(const RecordReader& reader, const FinishedSegments& finished, Verification& result) {
  for (const auto& damage : reader.damage()) {
    (is_torn_tail(damage, finished) ? result.torn_bytes : result.damaged_bytes) += damage.bytes;
    result.damage.push_back(place(damage.segment, damage.bytes, damage.offset) + damage.what);
  }
}

void list_altered(const RecordReader& reader, const std::filesystem::path& folder, const LogEvent& event,
                  const char* what, Verification& result) {
  const std::uint64_t bytes = kLogHeaderBytes + event.channel.size() + event.data.size();
  result.damage.push_back(place(segment_path(folder, reader.segment()), bytes, reader.offset()) + what);
}

void take_block(const RecordReader& reader, const std::filesystem::path& folder, const LogEvent& event,
                RecordState& state, Reading& reading) {
  SealedBlock& block = reading.block;
  if (accept(event, block) != Refusal::kNone ||
      event.channel != block_channel(block.header.node, block.kind)) {
    ++reading.result.blocks_refused;
    list_altered(reader, folder, event, "are an altered block", reading.result);
    return;
  }
  add(block, state);
  if (block.header.sequence <= 0) return;
  reading.epochs.add(block);
  reading.journal.add(block);
}

void take_note(const Note& note, Reading& reading) {
  if (note.kind == NoteKind::kStarted) reading.journal.restart();
  if (note.kind == NoteKind::kSegmentDeleted) reading.deleted.insert(static_cast<int>(note.a));
  if (note.kind == NoteKind::kMark) reading.last_mark = std::max(reading.last_mark, note.a);
  if (note.kind == NoteKind::kStopped) {
    reading.epochs_noted = std::max(reading.epochs_noted, note.a);
    reading.marks_noted = std::max(reading.marks_noted, note.b);
  }
  reading.result.alarms.take(note);
  reading.presence.take(note);
  reading.clocks.take(note);
  if (note.kind != NoteKind::kClock) reading.notes.emplace_back(note, reading.clocks.stamp(note.time_us));
}

/// By the clock as the record's end has it set.
void list_notes(Reading& reading) {
  for (auto& [note, stamp] : reading.notes) {
    note.time_us = reading.clocks.utc_us(stamp);
    (tells_of_loss(note) ? reading.result.lost : reading.result.notes).push_back(note_text(note));
  }
}

void take_other(const RecordReader& reader, const std::filesystem::path& folder, const LogEvent& event,
                Reading& reading) {
  bool good = true, is_other = false;
  if (event.channel == kJournalChannel) {
    const auto entry = decode_journal(event.data);
    good = entry.has_value();
    if (entry) reading.journal.add(*entry);
  } else if (event.channel == kNoteChannel) {
    const auto note = decode_note(event.data);
    good = note.has_value();
    if (note) take_note(*note, reading);
  } else if (event.channel == kCommitChannel) {
    good = decode_commit(event.data).has_value();
  } else {
    good = is_other = event.has_its_crc || !event.channel.starts_with("RB_");
  }
  is_other = is_other || (!good && is_of_newer_release(event.data));
  reading.result.other_events += is_other ? 1 : 0;
  if (good || is_other) return;
  ++reading.result.entries_refused;
  list_altered(reader, folder, event, "are an altered entry", reading.result);
}

void check_header(const RecordReader& reader, const std::filesystem::path& folder, const LogEvent& event,
                  Reading& reading) {
  const auto from = reading.headers.take(reader.segment(), reader.offset(), event);
  if (!from) return;
  ++reading.result.altered_headers;
  reading.result.damage.push_back(
      place(segment_path(folder, reader.segment()), reader.offset() - *from, *from) +
      "are events of which one is altered: number, stamp or channel, or contents with their CRC");
}

// An index may list less than its segment holds; an epoch that only the index lists must have been there.
void check_index(const std::filesystem::path& folder, int segment, RecordState& state, Disk& disk,
                 Reading& reading) {
  if (!path_exists(index_path(folder, segment), disk)) return;
  const auto listed = read_index_alone(folder, segment, disk);
  if (listed && reading.is_all)
    for (const auto& [key, epoch] : listed->epoch) {
      if (state.epoch.contains(key)) continue;
      ++reading.result.missing_segments;
      reading.result.damage.push_back(segment_path({}, segment).string() + ": node " +
                                      std::to_string(key.first) + " epoch " + std::to_string(key.second) +
                                      " is not here; its index names it");
    }
  const auto index = read_index(folder, segment, disk);
  if (index && !std::exchange(reading.is_begin_known, true)) state.epoch = index->epoch;
  if (!index || index->epoch != state.epoch)
    reading.result.indexes.push_back(index_path(folder, segment).filename().string() +
                                     ": is damaged, or says something else than its segment");
}

void read(const std::filesystem::path& folder, RecordReader& reader, Disk& disk, Reading& reading) {
  RecordState state;
  const RecordBeginning begin = beginning_of(folder, disk);
  const auto& before = begin.before;
  reading.is_all = before && before->segment == 0;
  reading.is_begin_known = before.has_value();
  if (before) {
    state.epoch = before->epoch;
    reading.journal.begin_behind(before->epoch);
  } else if (begin.is_in_other_folder) {
    reading.epochs.begin_anywhere();
  }
  int segment = reader.segment();
  while (const auto event = reader.next()) {
    if (reader.segment() != segment)
      check_index(folder, std::exchange(segment, reader.segment()), state, disk, reading);
    ++reading.result.events;
    reading.presence.take_time(event->timestamp_us);
    check_header(reader, folder, *event, reading);
    if (event->channel.starts_with(kBlockChannels))
      take_block(reader, folder, *event, state, reading);
    else
      take_other(reader, folder, *event, reading);
  }
  check_index(folder, segment, state, disk, reading);
  if (before && reading.deleted.contains(before->segment))
    reading.epochs.begin_behind(before->epoch);
  else
    reading.journal.nothing_was_deleted();  // anything that came before is missing
}

// The journal proves an epoch whose blocks are all gone.
void add_epochs_of_journal_only(Reading& reading) {
  auto& epochs = reading.result.epoch;
  for (const auto& [key, said] : reading.journal.contradictions()) {
    const auto is_it = [&key = key](const VerifiedEpoch& one) {
      return NodeEpoch(one.node, one.epoch) == key;
    };
    if (std::ranges::any_of(epochs, is_it)) continue;
    VerifiedEpoch epoch;
    epoch.node = key.first;
    epoch.epoch = key.second;
    const auto behind = std::ranges::upper_bound(epochs, epoch.node, {}, &VerifiedEpoch::node);
    epochs.insert(behind, std::move(epoch));
  }
}

void conclude(Reading& reading) {
  reading.result.epoch = reading.epochs.result();
  add_epochs_of_journal_only(reading);
  std::set<std::int32_t> ended;
  for (const VerifiedEpoch& epoch : reading.result.epoch)  // the last one of a node counts
    epoch.ended ? (void)ended.insert(epoch.node) : (void)ended.erase(epoch.node);
  for (const Absence& absence : reading.presence.absences(ended))
    reading.result.absent.push_back({.node = absence.node, .text = reading.presence.sentence(absence)});
  reading.result.journal_entries = reading.journal.entries();
  reading.result.deleted_segments = std::ssize(reading.deleted);
  for (auto& epoch : reading.result.epoch) {
    if (const auto counted = reading.journal.losses().find({epoch.node, epoch.epoch});
        counted != reading.journal.losses().end())
      epoch.losses = counted->second.node;
    const auto found = reading.journal.contradictions().find({epoch.node, epoch.epoch});
    if (found == reading.journal.contradictions().end()) continue;
    epoch.contradictions.insert(epoch.contradictions.end(), found->second.begin(), found->second.end());
  }
}

// None of them is a file of a recording: those that are must be regular, or are not read at all.
void list_irregular(const std::filesystem::path& folder, Disk& disk, Verification& result) {
  for (const std::string& name : list_folder(folder, disk))
    if (const std::string kind = irregular_kind(folder / name); !kind.empty())
      result.not_read.push_back(printable_text(name) + ": is " + kind + ", which is not read");
  std::ranges::sort(result.not_read);
}

Verdict judge(const Verification& result) {
  bool damaged = result.blocks_refused > 0 || result.entries_refused > 0 || result.damaged_bytes > 0 ||
                 result.altered_headers > 0 || result.missing_segments > 0;
  bool complete = result.damage.empty() && result.lost.empty() && result.absent.empty() &&
                  result.elsewhere.empty() && !result.epoch.empty();
  for (const auto& epoch : result.epoch) {
    damaged = damaged || epoch.is_damaged();
    complete = complete && epoch.is_complete();
  }
  if (damaged) return Verdict::kDamaged;
  return complete ? Verdict::kComplete : Verdict::kIncomplete;
}

}  // namespace

Verification verify_record(const std::filesystem::path& folder, Disk& on) {
  Verification result;
  RescueDisk disk(on);
  try {
    RecordReader reader(folder, disk);
    reader.finish();
    Reading reading{.result = result};
    read(folder, reader, disk, reading);
    list_notes(reading);
    if (result.epoch.empty())
      if (const std::string foreign = foreign_words(folder, disk); !foreign.empty())
        throw std::runtime_error(folder.string() + ": " + foreign);
    const FinishedSegments finished = read_manifest(folder, disk);
    if (is_manifest_damaged(folder, disk)) result.indexes.push_back("manifest.json: is damaged");
    list_damage(reader, finished, result);
    list_missing_segments(folder, finished, disk, reading);
    for (const std::string& line : find_elsewhere({folder}, disk))
      result.elsewhere.push_back(line + "; rb recover makes one recording of both");
    list_irregular(folder, disk, result);
    compare_with_stops(reading);
    conclude(reading);
    result.verdict = judge(result);
  } catch (const std::exception& error) {
    result.verdict = Verdict::kUnreadable;
    result.error = error.what();
  }
  return result;
}

namespace {

std::string number(std::int64_t value) {
  return std::to_string(value);
}

}  // namespace

std::string verdict_text(const Verification& result) {
  switch (result.verdict) {
    case Verdict::kComplete:
      return "complete";
    case Verdict::kDamaged:
      return "damaged";
    case Verdict::kUnreadable:
      return "unreadable";
    case Verdict::kIncomplete:
      break;
  }
  if (result.epoch.empty()) return "incomplete: it describes itself, but no block of a node is there";
  if (!result.elsewhere.empty()) return "incomplete, the rest of it is in another folder";
  if (!result.absent.empty())
    return "incomplete: " + result.absent.front().text +
           (result.absent.size() > 1 ? "; and " + number(std::ssize(result.absent) - 1) + " more" : "");
  const bool open = !result.damage.empty() || std::any_of(result.epoch.begin(), result.epoch.end(),
                                                          [](const auto& epoch) { return epoch.is_open(); });
  if (open) return "incomplete, no end: what came after is unknown";
  return result.lost.empty() ? "incomplete, every gap declared" : "incomplete, what is lost is listed";
}

namespace {

// "ALARM node 1: samples lost"
std::string alarm_text(const Note& note) {
  const bool began = note.kind == NoteKind::kAlarmBegan;
  if (!is_alarm_cause(note.a)) return "alarm " + number(note.a) + (began ? "" : " is over");
  return sentence_of(alarm_of(note.a, note.b)) + (began ? "" : " is over");
}

// Writes a length; a record may hold anything.
std::string seconds_text(std::int64_t length_us) {
  const std::int64_t us = std::clamp(length_us, -kUtcLimit_us, kUtcLimit_us) * (length_us < 0 ? -1 : 1);
  return number(us / 1'000'000) + "." + number(us / 100'000 % 10) + " s";
}

std::string what_happened(const Note& note) {
  switch (note.kind) {
    case NoteKind::kStarted:
      return "recorder started, from segment " + number(note.a) + " on";
    case NoteKind::kStopped:
      return "recorder stopped as asked";
    case NoteKind::kClock:
      return "clocks";
    case NoteKind::kDiskFailed:
      if (tells_of_loss(note)) return "lost from the recording that this one was made of";
      return "disk failed, error " + number(note.a) + ", in segment " + number(note.b);
    case NoteKind::kSegmentAbandoned:
      return "segment " + number(note.a) + " abandoned: it ends at byte " + number(note.b);
    case NoteKind::kDiskFull:
      return "disk full, " + number(note.a) + " bytes free";
    case NoteKind::kDiskFree:
      return "recording goes on, " + number(note.a) + " bytes free";
    case NoteKind::kFallback:
      return "fallback folder from here on";
    case NoteKind::kPowerLost:
      return "supply lost";
    case NoteKind::kPowerReturned:
      return "supply returned";
    case NoteKind::kSegmentDeleted:
      return "segment " + number(note.a) + " deleted by the retention mode, " + number(note.b) + " bytes";
    case NoteKind::kTailCut:
      return number(note.b) + " bytes behind the last event of segment " + number(note.a) +
             " cut, and kept beside";
    case NoteKind::kPowerUnknown:
      return note.a != 0 ? "whether the supply is there cannot be read" : "the supply can be read again";
    case NoteKind::kDevice:
      return "devices of node " + number(note.a);
    case NoteKind::kEndContradicts:
      return "the blocks received of node " + number(note.a) + " are not those that its end, block " +
             number(note.b) + ", sums up";
    case NoteKind::kMark:
      return "mark " + number(note.a);
    case NoteKind::kAsked:
      return "asked";
    case NoteKind::kSubset:
      return note.a == 0 ? "made of another recording" : "part " + number(note.a);
    case NoteKind::kSubsetEpoch:
      return "epoch " + number(note.a) + " is made of epoch " + number(note.b);
    case NoteKind::kImported:
      return "made of another program's samples";
    case NoteKind::kAlarmBegan:
    case NoteKind::kAlarmEnded:
      return alarm_text(note);
    case NoteKind::kNodeMissing:
      return node_words(static_cast<std::int32_t>(note.a), printable_text(note.text)) +
             " does not measure: " + words(static_cast<AbsenceCause>(note.b));
    case NoteKind::kNodeThere:
      return node_words(static_cast<std::int32_t>(note.a), printable_text(note.text)) +
             (note.b != 0 ? " measures" : " is heard again, and has what it measured meanwhile");
    case NoteKind::kStopping:
      return "the recording is stopped by";
    case NoteKind::kClockSet:
      return "the wall clock of the recorder's computer was set " + seconds_text(note.a) +
             (note.a < 0 ? " back" : " forward");
    case NoteKind::kSlept:
      return "the recorder's computer was suspended for " + seconds_text(note.a);
    case NoteKind::kDiskLow:
      return "disk full in " + number(note.a) + " s at this rate, " + number(note.b) + " bytes free";
  }
  return "note of kind " + number(static_cast<std::int64_t>(note.kind)) + " (" + number(note.a) + ", " +
         number(note.b) + ")";
}

}  // namespace

std::string note_text(const Note& note) {
  const std::string when = note.time_us != 0 ? utc_text(note.time_us) + " " : "";
  const bool has_its_text = note.kind == NoteKind::kNodeMissing || note.kind == NoteKind::kNodeThere;
  return when + what_happened(note) +
         (note.text.empty() || has_its_text ? "" : ": " + printable_text(note.text));
}

}  // namespace roadbalance
