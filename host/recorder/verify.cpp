#include "host/recorder/verify.hpp"

#include <algorithm>
#include <exception>
#include <map>
#include <stdexcept>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/folder.hpp"
#include "common/record/header_check.hpp"
#include "common/record/log_event.hpp"
#include "common/record/record.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "host/recorder/foreign_log.hpp"
#include "host/recorder/manifest.hpp"
#include "host/recorder/verify_journal.hpp"
#include "host/recorder/verify_missing.hpp"

namespace roadbalance {
namespace {

struct Reading {
  Verification& result;
  EpochCheck epochs{};
  JournalCheck journal{};
  HeaderCheck headers{};
  SealedBlock block{};      // the last; here, since making one clears all it holds
  int deleted_through = 0;  // segment, by the notes
};

void list_missing_segments(const std::filesystem::path& folder, const FinishedSegments& finished, Disk& disk,
                           Reading& reading) {
  const MissingSegments found = find_missing_segments(folder, finished, reading.deleted_through, disk);
  reading.result.missing_segments = found.missing;
  reading.result.damage.insert(reading.result.damage.end(), found.lines.begin(), found.lines.end());
}

std::string place(const std::filesystem::path& segment, std::uint64_t bytes, std::uint64_t offset) {
  return segment.filename().string() + ": " + std::to_string(bytes) + " bytes from " +
         std::to_string(offset) + " on are ";
}

void list_damage(const RecordReader& reader, const FinishedSegments& finished, Verification& result) {
  for (const auto& damage : reader.damage()) {
    (is_torn_tail(damage, finished) ? result.torn_bytes : result.damaged_bytes) += damage.bytes;
    result.damage.push_back(place(damage.segment, damage.bytes, damage.offset) + damage.what);
  }
}

void take_block(const RecordReader& reader, const std::filesystem::path& folder, const LogEvent& event,
                RecordState& state, Reading& reading) {
  SealedBlock& block = reading.block;
  if (accept(event, block) != Refusal::kNone ||
      event.channel != block_channel(block.header.node, block.kind)) {
    ++reading.result.blocks_refused;
    const std::uint64_t bytes = kLogHeaderBytes + event.channel.size() + event.data.size();
    reading.result.damage.push_back(place(segment_path(folder, reader.segment()), bytes, reader.offset()) +
                                    "an altered block");
    return;
  }
  add(block, state);
  if (block.header.sequence <= 0) return;
  reading.epochs.add(block);
  reading.journal.add(block);
}

void take_note(const Note& note, Reading& reading) {
  if (note.kind == NoteKind::kStarted) reading.journal.restart();
  if (note.kind == NoteKind::kSegmentDeleted) {
    ++reading.result.deleted_segments;
    reading.deleted_through = std::max(reading.deleted_through, static_cast<int>(note.a));
  }
  reading.result.alarms.take(note);
  if (note.kind != NoteKind::kClock) reading.result.notes.push_back(note_text(note));
}

void take_other(const LogEvent& event, Reading& reading) {
  bool good = true;
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
    ++reading.result.other_events;
  }
  reading.result.entries_refused += good ? 0 : 1;
}

void check_header(const RecordReader& reader, const std::filesystem::path& folder, const LogEvent& event,
                  Reading& reading) {
  const auto from = reading.headers.take(reader.segment(), reader.offset(), event);
  if (!from) return;
  ++reading.result.altered_headers;
  reading.result.damage.push_back(
      place(segment_path(folder, reader.segment()), reader.offset() - *from, *from) +
      "events of which one has an altered number, stamp or channel");
}

void check_index(const std::filesystem::path& folder, int segment, const RecordState& state, Disk& disk,
                 Verification& result) {
  if (!path_exists(index_path(folder, segment), disk)) return;
  const auto index = read_index(folder, segment, disk);
  if (!index || index->epoch != state.epoch)
    result.indexes.push_back(index_path(folder, segment).filename().string() +
                             ": is damaged, or says something else than its segment");
}

void read(const std::filesystem::path& folder, RecordReader& reader, Disk& disk, Reading& reading) {
  RecordState state;
  if (const auto deleted = read_index_of_deleted(folder, reader.segment() - 1, disk)) {
    state.epoch = deleted->epoch;
    reading.epochs.begin_behind(deleted->epoch);
    reading.journal.begin_behind(deleted->epoch);
  }
  int segment = reader.segment();
  while (const auto event = reader.next()) {
    if (reader.segment() != segment)
      check_index(folder, std::exchange(segment, reader.segment()), state, disk, reading.result);
    ++reading.result.events;
    check_header(reader, folder, *event, reading);
    if (event->channel.starts_with(kBlockChannels))
      take_block(reader, folder, *event, state, reading);
    else
      take_other(*event, reading);
  }
  check_index(folder, segment, state, disk, reading.result);
}

void conclude(Reading& reading) {
  reading.result.epoch = reading.epochs.result();
  reading.result.journal_entries = reading.journal.entries();
  for (auto& epoch : reading.result.epoch) {
    if (const auto counted = reading.journal.losses().find({epoch.node, epoch.epoch});
        counted != reading.journal.losses().end())
      epoch.losses = counted->second.node;
    const auto found = reading.journal.contradictions().find({epoch.node, epoch.epoch});
    if (found == reading.journal.contradictions().end()) continue;
    epoch.contradictions.insert(epoch.contradictions.end(), found->second.begin(), found->second.end());
  }
}

Verdict judge(const Verification& result) {
  bool damaged = result.blocks_refused > 0 || result.entries_refused > 0 || result.damaged_bytes > 0 ||
                 result.altered_headers > 0 || result.missing_segments > 0;
  bool complete = result.damage.empty() && !result.epoch.empty();
  for (const auto& epoch : result.epoch) {
    damaged = damaged || epoch.is_damaged();
    complete = complete && epoch.is_complete();
  }
  if (damaged) return Verdict::kDamaged;
  return complete ? Verdict::kComplete : Verdict::kIncomplete;
}

}  // namespace

Verification verify_record(const std::filesystem::path& folder, Disk& disk) {
  Verification result;
  try {
    RecordReader reader(folder, disk);
    reader.finish();
    Reading reading{.result = result};
    read(folder, reader, disk, reading);
    if (result.epoch.empty())
      if (const std::string foreign = foreign_words(folder, disk); !foreign.empty())
        throw std::runtime_error(folder.string() + ": " + foreign);
    const FinishedSegments finished = read_manifest(folder, disk);
    list_damage(reader, finished, result);
    list_missing_segments(folder, finished, disk, reading);
    conclude(reading);
    result.verdict = judge(result);
  } catch (const std::exception& error) {
    result.verdict = Verdict::kUnreadable;
    result.error = error.what();
  }
  return result;
}

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
  const bool open = !result.damage.empty() || std::any_of(result.epoch.begin(), result.epoch.end(),
                                                          [](const auto& epoch) { return epoch.is_open(); });
  return open ? "incomplete, no end: what came after is unknown" : "incomplete, every gap declared";
}

}  // namespace roadbalance
