#include "host/recording/recover/recover.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/folder.hpp"
#include "common/record/header_check.hpp"
#include "common/record/journal_counters.hpp"
#include "common/record/log_event.hpp"
#include "common/record/record_writer.hpp"
#include "common/record/segment.hpp"
#include "host/recording/continued_folders.hpp"
#include "host/recording/manifest.hpp"
#include "host/recording/preamble.hpp"
#include "host/recording/recover/recovered_clocks.hpp"
#include "host/recording/recover/recovered_epoch.hpp"
#include "host/recording/recover/recovered_losses.hpp"
#include "host/recording/recover/recovery_sources.hpp"
#include "host/recording/recover/sequence_set.hpp"
#include "host/recording/verify/verify_missing.hpp"

namespace roadbalance {
namespace {

using Place = RecoverySources::Place;
// Blocks for one journal entry: about one second of a node.
constexpr std::int64_t kBlocksPerEntry = 128;

/// One node epoch as the first pass finds it.
struct Plan {
  std::int64_t highest = 0;  // so far, in the order of reading
  SequenceSet seen;
  std::map<std::int64_t, Place> elsewhere;  // blocks that stand behind later ones
  RecoveredEpoch out;
  std::int64_t blocks_in_entry = 0;
};

bool is_declared_by_host(const SealedBlock& block) {
  return block.kind == BlockKind::kGap && is_declared_by_host(decode_gap(block).cause);
}

// Notes on files that the new record does not have.
bool speaks_of_segments(const Note& note) {
  return note.kind == NoteKind::kSegmentAbandoned || note.kind == NoteKind::kSegmentDeleted ||
         note.kind == NoteKind::kTailCut;
}

bool is_copied(const LogEvent& event) {
  if (event.channel == kJournalChannel || event.channel == kCommitChannel) return false;
  if (event.channel.starts_with(kBlockChannels) || !event.channel.starts_with("RB_")) return false;
  if (!event.has_its_crc) return false;
  if (event.channel != kNoteChannel) return true;
  const auto note = decode_note(event.data);
  return note && !speaks_of_segments(*note);
}

class Recover {
 public:
  Recover(const std::vector<std::filesystem::path>& folders, Disk& disk)
      : folders_(folders), disk_(disk), sources_(folders, disk) {
    is_continuation_ = std::ranges::any_of(
        folders, [&](const auto& folder) { return path_exists(folder / kContinuesFile, disk); });
  }

  Recovered run(const std::filesystem::path& target, Disk& disk) {
    std::vector<RecordReader::Damage> damage;
    sources_.for_each(
        [this](const LogEvent& event, const Place& place, bool counts) { plan(event, place, counts); },
        damage);
    for (const auto& piece : damage) {
      result_.damaged_bytes += piece.bytes;
      if (!piece.torn) losses_.damaged(piece.bytes);
      result_.damage.push_back(piece.segment.string() + ": " + std::to_string(piece.bytes) + " bytes from " +
                               std::to_string(piece.offset) + " on " + piece.what);
    }
    list_missing_segments();
    if (plans_.empty()) throw std::runtime_error("no good block is there to be recovered");
    writer_.emplace(RecordWriter::Options{.folder = target}, disk);
    writer_->set_preamble([events = make_preamble(vehicle_.vehicle)](const RecordState&) { return events; });
    for (auto& [key, plan] : plans_) plan.highest = 0;
    sources_.for_each(
        [this](const LogEvent& event, const Place& place, bool counts) { write(event, place, counts); },
        damage);
    for (auto& [key, plan] : plans_) finish(key, plan);
    declare_losses();
    writer_->close();
    write_manifest(target, std::nullopt, disk);
    return std::move(result_);
  }

 private:
  // Holes that the segments' ends and the folders prove.  A spool begins where it was emptied to.
  void list_missing_segments() {
    for (const auto& line : find_elsewhere(folders_, disk_)) losses_.elsewhere(line);
    for (const auto& folder : folders_) {
      const auto finished = read_manifest(folder, disk_);
      const auto found =
          find_missing_segments(folder, finished, deleted_[segment_path(folder, 1).parent_path()], disk_);
      for (const SegmentRun run : found.deleted) losses_.deleted_segments(name_of_folder(folder), run);
      if (folder != folders_.front() && finished.empty()) continue;
      result_.missing_segments += found.missing;
      losses_.missing_segments(found.missing);
      for (const auto& line : found.lines) result_.damage.push_back((folder / line).string());
    }
  }

  void declare_losses() {
    result_.lost = losses_.lines([this](const NodeEpoch& key) { return plans_.contains(key); });
    for (const std::string& line : result_.lost)
      writer_->append(kNoteChannel, encode(note_of_loss(line)), last_timestamp_us_);
  }

  void check_header(const LogEvent& event, const Place& place) {
    const auto from = headers_.take(static_cast<int>(place.file) + 1, place.offset, event);
    if (!from) return;
    ++result_.headers_altered;
    losses_.altered_header();
    result_.damage.push_back(
        sources_.file(place).string() + ": " + std::to_string(place.offset - *from) + " bytes from " +
        std::to_string(*from) +
        " on are events of which one is altered: number, stamp or channel, or contents with their CRC");
  }

  // Bytes behind the end of an abandoned segment are no hole: they were written again.
  void list_altered(const LogEvent& event, const Place& place, const char* what) {
    const std::uint64_t bytes = kLogHeaderBytes + event.channel.size() + event.data.size();
    result_.damage.push_back(sources_.file(place).string() + ": " + std::to_string(bytes) + " bytes from " +
                             std::to_string(place.offset) + " on are " + what);
  }

  void plan_other(const LogEvent& event, const Place& place) {
    if (event.channel.starts_with(kBlockChannels)) {
      ++result_.blocks_altered;
      if (!sources_.is_torn(place)) losses_.altered_block(event);
      list_altered(event, place, "an altered block");
    } else if (event.channel.starts_with("RB_") && !event.has_its_crc) {
      ++result_.entries_altered;
      if (!sources_.is_torn(place)) losses_.altered_entry();
      list_altered(event, place, "an altered entry");
    } else if (event.channel == kNoteChannel) {
      const auto note = decode_note(event.data);
      if (note && note->kind == NoteKind::kSegmentDeleted)
        deleted_[sources_.file(place).parent_path()].insert(static_cast<int>(note->a));
    }
  }

  void plan(const LogEvent& event, const Place& place, bool counts) {
    SealedBlock block;
    if (counts && !sources_.is_torn(place)) check_header(event, place);
    if (accept(event, block) != Refusal::kNone) {
      if (counts) plan_other(event, place);
      return;
    }
    if (block.kind == BlockKind::kMeta) add(block, vehicle_);
    if (block.header.sequence <= 0) return;
    Plan& plan = plans_[{block.header.node, block.header.epoch}];
    if (is_declared_by_host(block)) return plan.out.declared(block, event.timestamp_us);
    if (!plan.seen.insert(block.header.sequence)) {
      ++result_.blocks_repeated;
    } else if (block.header.sequence < plan.highest) {
      plan.elsewhere.emplace(block.header.sequence, place);
    } else {
      plan.highest = block.header.sequence;
    }
  }

  void write(const LogEvent& event, const Place& place, bool counts) {
    SealedBlock block;
    if (accept(event, block) != Refusal::kNone) {
      if (counts) write_other(event);
      return;
    }
    if (block.header.sequence <= 0 || is_declared_by_host(block)) return;
    const NodeEpoch key{block.header.node, block.header.epoch};
    const auto planned = plans_.find(key);
    if (planned == plans_.end())
      throw std::runtime_error(sources_.file(place).string() + ": changed while it was read");
    Plan& plan = planned->second;
    if (block.header.sequence <= plan.highest) return;
    plan.highest = block.header.sequence;
    write_elsewhere_before(block.header.sequence, key, plan);
    put(block, event.timestamp_us, key, plan);
  }

  void write_other(const LogEvent& event) {
    if (event.channel == kJournalChannel)
      if (auto entry = decode_journal(event.data)) {
        Journal& counted = counted_[{entry->node, entry->epoch}];
        entry->node_losses.raise(counted.node_losses);
        counted = *entry;
      }
    if (!is_copied(event)) return;
    if (event.channel == kNoteChannel) {
      const NoteKind kind = decode_note(event.data)->kind;
      if (kind == NoteKind::kStarted) begin_run();
      if (kind == NoteKind::kStopped && is_continuation_) return;
    }
    if (!clocks_.is_new(event.channel, event.data)) return;
    writer_->append(event.channel, event.data, event.timestamp_us);
  }

  // Behind the note that a recorder began, the journal begins anew, and so do the recorder's counts.
  void begin_run() {
    for (auto& [key, plan] : plans_)
      if (plan.blocks_in_entry > 0) write_entry(key, plan, last_timestamp_us_);
    journal_ = {};
    for (auto& [key, counted] : counted_) counted = {.node_losses = counted.node_losses};
  }

  void write_elsewhere_before(std::int64_t sequence, const NodeEpoch& key, Plan& plan) {
    while (!plan.elsewhere.empty() && plan.elsewhere.begin()->first < sequence) {
      std::int64_t timestamp_us = 0;
      const SealedBlock block = sources_.block_at(plan.elsewhere.begin()->second, timestamp_us);
      plan.elsewhere.erase(plan.elsewhere.begin());
      ++result_.blocks_filled;
      put(block, timestamp_us, key, plan);
    }
  }

  void put(const SealedBlock& block, std::int64_t timestamp_us, const NodeEpoch& key, Plan& plan) {
    plan.out.put(block, timestamp_us, writing(key, plan));
  }

  RecoveredEpoch::Write writing(const NodeEpoch& key, Plan& plan) {
    return [this, &key, &plan](const SealedBlock& block, std::int64_t timestamp_us) {
      writer_->append(block, timestamp_us);
      ++(is_declared_by_host(block) ? result_.gaps : result_.blocks);
      journal_.add(block);
      if (++plan.blocks_in_entry >= kBlocksPerEntry) write_entry(key, plan, timestamp_us);
      last_timestamp_us_ = timestamp_us;
    };
  }

  void write_entry(const NodeEpoch& key, Plan& plan, std::int64_t timestamp_us) {
    plan.blocks_in_entry = 0;
    Journal entry = journal_.take(key.first, key.second);
    entry.time_us = timestamp_us;
    const Journal& counted = counted_[key];
    entry.node_losses = counted.node_losses;
    entry.refused = counted.refused;
    entry.rivals = counted.rivals;
    entry.unsent = counted.unsent;
    entry.disk_failures = counted.disk_failures;
    writer_->append(kJournalChannel, encode(entry), timestamp_us);
  }

  void finish(const NodeEpoch& key, Plan& plan) {
    plan.out.finish(writing(key, plan));
    if (plan.blocks_in_entry > 0) write_entry(key, plan, last_timestamp_us_);
  }

  const std::vector<std::filesystem::path> folders_;
  bool is_continuation_ = false;  ///< blocks that its recorder counts at its end may lie in another folder
  Disk& disk_;
  RecoverySources sources_;
  std::map<std::filesystem::path, std::set<int>> deleted_;  // segments, by the folder's notes
  std::optional<RecordWriter> writer_;
  std::map<NodeEpoch, Plan> plans_;
  HeaderCheck headers_;
  RecoveredLosses losses_;
  RecordState vehicle_;  // only the descriptions in it count
  RecoveredClocks clocks_;
  JournalCounters journal_;
  std::map<NodeEpoch, Journal> counted_;  // losses of the nodes, and of this run of the recorder
  std::int64_t last_timestamp_us_ = 0;
  Recovered result_;
};

}  // namespace

Recovered recover(const std::vector<std::filesystem::path>& sources, const std::filesystem::path& target,
                  Disk& disk) {
  RescueDisk readable(disk);
  return Recover(sources, readable).run(target, disk);
}

}  // namespace roadbalance
