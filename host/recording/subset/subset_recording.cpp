#include "host/recording/subset/subset_recording.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/scan_format.hpp"
#include "common/record/folder.hpp"
#include "common/record/journal_counters.hpp"
#include "common/record/part.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/record_writer.hpp"
#include "common/record/room.hpp"
#include "common/record/segment.hpp"
#include "host/recording/continued_folders.hpp"
#include "host/recording/in_sequence.hpp"
#include "host/recording/manifest.hpp"
#include "host/recording/preamble.hpp"
#include "host/recording/subset/channel_choice.hpp"
#include "host/recording/subset/epoch_clocks.hpp"
#include "host/recording/subset/epoch_writer.hpp"
#include "host/recording/subset/find_pieces.hpp"
#include "host/recording/subset/reducing_sink.hpp"
#include "host/recording/subset/subset_epoch.hpp"
#include "host/recording/subset/subset_notes.hpp"

namespace roadbalance {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

std::string ordinal(int factor) {
  const bool teen = factor % 100 / 10 == 1;
  const char* const ending = teen               ? "th"
                             : factor % 10 == 1 ? "st"
                             : factor % 10 == 2 ? "nd"
                             : factor % 10 == 3 ? "rd"
                                                : "th";
  return std::to_string(factor) + ending;
}

std::string list(const std::string& title, const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "; " + title + " " : ", ") + name;
  return text;
}

std::string limit(const char* title, const std::optional<double>& seconds,
                  const std::optional<std::int64_t>& mark) {
  if (!seconds && !mark) return "";
  std::string text = std::string(title) + number(seconds.value_or(0.0)) + " s";
  if (mark) text += " of mark " + std::to_string(*mark);
  return text;
}

/// "every 4th sample of monday, from 60 s to 120 s; nodes front": the source of the recording, for people.
std::string subset_words(const SubsetRequest& request) {
  const TimeChoice& time = request.time;
  std::string text = request.factor > 1 ? "every " + ordinal(request.factor) + " sample of " : "part of ";
  text += std::filesystem::canonical(request.folder).filename().string();
  text += limit(", from ", time.from_s, time.from_mark) + limit(", to ", time.to_s, time.to_mark);
  if (time.least_m_s) text += ", at " + number(*time.least_m_s * 3.6) + " km/h and more";
  if (time.most_m_s) text += ", below " + number(*time.most_m_s * 3.6) + " km/h";
  if (time.clean) text += ", clean";
  return text + list("nodes", request.choice.nodes) + list("channels", request.choice.channels);
}

/// "from 12.000 s to 20.500 s", since the original's first sample.
std::string piece_words(const Piece& piece, std::int64_t start_ns) {
  char text[96];
  const auto seconds = [&](std::int64_t ns) { return static_cast<double>(ns - start_ns) * 1e-9; };
  if (piece.from_ns == std::numeric_limits<std::int64_t>::min())
    std::snprintf(text, sizeof text, "from the beginning");
  else
    std::snprintf(text, sizeof text, "from %.3f s", seconds(piece.from_ns));
  std::string words = text;
  if (piece.to_ns == Piece::kEver) return words + " to the end";
  std::snprintf(text, sizeof text, " to %.3f s", seconds(piece.to_ns));
  return words + text;
}

/// The number of the epoch that a piece of an epoch becomes: the same request gives the same one, another
/// request another (FNV-1a).
std::int64_t subset_epoch_number(std::int64_t epoch, const std::string& words, const Piece& piece) {
  std::uint64_t hash = 14695981039346656037ULL;
  const auto mix = [&](const void* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211ULL;
  };
  mix(&epoch, sizeof epoch);
  mix(words.data(), words.size());
  mix(&piece.from_ns, sizeof piece.from_ns);
  mix(&piece.to_ns, sizeof piece.to_ns);
  return static_cast<std::int64_t>(hash >> 2) + 1;
}

/// Scans at the ends of a piece that do not count: parts of blocks, and rounding of times.
constexpr double kUnsure = 2.0 * kScansPerBlock;
/// New samples that the filter of rb reduce leaves out at the ends of a stretch.
constexpr double kFiltered = 2.0 * 35.0;

double scans_in(const RecordedSpan& span, const Piece& piece) {
  const double from_ns = static_cast<double>(std::max(span.first_host_ns(), piece.from_ns));
  const double to_ns = static_cast<double>(std::min(span.end_ns(), piece.to_ns));
  return std::max(0.0, 1000.0 * (to_ns - from_ns) / static_cast<double>(span.period_ps) - kUnsure);
}

/// The least that the new recording takes on its disk: the scans of the chosen nodes in these pieces, in full
/// blocks.  All that is missing in the recording is taken to be missing there; edges, signals and the journal
/// come on top.  So it refuses nothing that would fit.
std::uint64_t least_subset_bytes(const SubsetRequest& request, const RecordingSurvey& survey,
                                 const Pieces& pieces) {
  double blocks = 0.0;
  for (const RecordedSpan& span : survey.span) {
    const NodeConfig* node = survey.vehicle.node_with_id(span.node);
    const bool is_timed = span.first_fit || !survey.own_clocks();
    if (node == nullptr || !is_timed || chosen_channels(request.choice, *node) == 0) continue;
    const std::int64_t missing = span.next_scan - span.first_scan - span.samples;
    double scans = -static_cast<double>(missing);
    for (const Piece& piece : pieces) {
      const double here = scans_in(span, piece);
      scans += request.factor > 1 ? std::max(0.0, here / request.factor - kFiltered) : here;
    }
    // The filter leaves out more at each gap, and the number of gaps is unknown.
    if (request.factor > 1 && missing > 0) scans = 0.0;
    blocks += std::max(0.0, scans) / kScansPerBlock;
  }
  return static_cast<std::uint64_t>(blocks * static_cast<double>(wire_format::kScanBytes));
}

/// Blocks of an epoch in one journal entry: about a second.
constexpr std::int64_t kBlocksPerEntry = 128;

/// The new record: writes its segments' preamble, its journal and its manifest.
class SubsetRecord {
 public:
  /// @throws as RecordWriter
  explicit SubsetRecord(const std::filesystem::path& folder);

  /// Events put from here on bear this time.
  void at(std::int64_t timestamp_us) { timestamp_us_ = timestamp_us; }
  void put(std::string_view channel, std::span<const std::uint8_t> data);
  /// @param losses  of its node in its epoch so far
  void put(const SealedBlock& block, const NodeLosses& losses);
  /// Syncs, closes, lists the segments.
  void close();

 private:
  struct Open {
    std::int64_t blocks = 0;  ///< since the last entry of the journal
    NodeLosses losses = {};
  };
  void write_entry(const NodeEpoch& key, Open& open);

  const std::filesystem::path folder_;
  RecordWriter writer_;
  JournalCounters journal_;
  std::map<NodeEpoch, Open> open_;
  std::int64_t timestamp_us_ = 0;
};

SubsetRecord::SubsetRecord(const std::filesystem::path& folder)
    : folder_(folder), writer_({.folder = folder}) {
  writer_.set_preamble([](const RecordState& holds) { return make_preamble(holds); });
}

void SubsetRecord::put(std::string_view channel, std::span<const std::uint8_t> data) {
  writer_.append(channel, data, timestamp_us_);
}

void SubsetRecord::put(const SealedBlock& block, const NodeLosses& losses) {
  writer_.append(block, timestamp_us_);
  journal_.add(block);
  const NodeEpoch key{block.header.node, block.header.epoch};
  Open& open = open_[key];
  open.losses = losses;
  ++open.blocks;
  const bool ends = block.kind == BlockKind::kEnd;
  if (open.blocks >= kBlocksPerEntry || ends) write_entry(key, open);
  if (ends) open_.erase(key);
}

void SubsetRecord::write_entry(const NodeEpoch& key, Open& open) {
  open.blocks = 0;
  Journal entry = journal_.take(key.first, key.second);
  entry.time_us = timestamp_us_;
  entry.node_losses = open.losses;
  put(kJournalChannel, encode(entry));
}

void SubsetRecord::close() {
  for (auto& [key, open] : open_)
    if (open.blocks > 0) write_entry(key, open);
  writer_.close();
  write_manifest(folder_);
}

/// The original's events on their way into the record: blocks cut into pieces, clocks, journal and notes.
class Subset {
 public:
  Subset(const SubsetRequest& request, const RecordingSurvey& survey, const ExportTable& table,
         const Pieces& pieces, SubsetRecord& record)
      : request_(request),
        survey_(survey),
        start_ns_(table.start_ns),
        pieces_(pieces),
        words_(subset_words(request)),
        clocks_(survey),
        record_(record),
        in_sequence_(InSequence::of_record(request.folder)) {}

  void take(const LogEvent& event) {
    record_.at(event.timestamp_us);
    clocks_.take(event);
    const auto fit = recorded_clocks_.take(event.channel, event.data);
    if (event.channel.starts_with(kBlockChannels)) return take_block(event);
    if (event.channel == kJournalChannel) return take_journal(event);
    if (event.channel == kNoteChannel) return take_note(event);
    if (fit) return put_for_all(*fit, clock_fit_channel(fit->node));
    if (const auto exchange = decode_clock_exchange(event.data))
      put_for_all(*exchange, clock_exchange_channel(exchange->node));
  }

  void finish() {
    for (auto& [key, source] : sources_)
      if (source.epoch) source.epoch->finish();
    for (const auto& [node, missing] : missing_)
      if (lies_in_a_piece(missing, Piece::kEver)) record_.put(kNoteChannel, encode(missing));
    for (const std::string& line : find_elsewhere({request_.folder}))
      record_.put(kNoteChannel, encode(note_of_loss(line)));
  }
  std::int64_t missing_blocks() const { return in_sequence_.missing(); }
  std::int64_t refused_blocks() const { return refused_; }
  bool holds_scans() const { return holds_scans_; }
  const std::string& words() const { return words_; }

 private:
  /// A node epoch of the original.
  struct Source {
    std::map<std::int32_t, std::string> vehicle;  ///< parts of its vehicle.toml
    std::unique_ptr<SubsetEpoch> epoch;           ///< nullptr: not wanted
    std::map<std::size_t, std::int64_t> open;     ///< numbers of the new epochs under way, by piece
    NodeLosses losses;
  };

  void take_block(const LogEvent& event) {
    if (accept(event, *block_) != Refusal::kNone) {
      ++refused_;
      return;
    }
    if (block_->kind == BlockKind::kMeta) {
      const MetaBlock meta = decode_meta(*block_);
      if (meta.kind == MetaKind::kVehicleToml)
        sources_[{meta.header.node, meta.header.epoch}].vehicle[meta.part] = meta.text;
    }
    in_sequence_.add(*block_, [&](const SealedBlock& block) {
      const NodeEpoch key{block.header.node, block.header.epoch};
      Source& source = sources_[key];
      if (block.kind == BlockKind::kScan) {
        last_sample_ns_ = block.header.time_ns + block.header.scans * summary_of(block).period_ps / 1000;
        if (!source.epoch) source.epoch = begin(key, source, summary_of(block).period_ps);
      }
      if (!source.epoch && block.kind != BlockKind::kMeta) source.epoch = begin(key, source, 0);
      if (source.epoch) source.epoch->take(block);
    });
  }

  std::unique_ptr<SubsetEpoch> begin(const NodeEpoch& key, Source& source, std::int64_t period_ps) {
    const NodeConfig* node = survey_.vehicle.node_with_id(key.first);
    const EpochClock* clock = clocks_.of(key);
    const std::uint32_t chosen = node && clock ? chosen_channels(request_.choice, *node) : 0;
    if (chosen == 0) return nullptr;
    for (const RecordedSpan& span : survey_.span)
      if (NodeEpoch{span.node, span.epoch} == key) period_ps = span.period_ps;
    const std::uint32_t kept = request_.choice.channels.empty() ? ~0U : chosen;
    return std::make_unique<SubsetEpoch>(
        *clock, pieces_, period_ps, kept,
        [this, key, &source](std::size_t piece) { return sink(key, source, piece); });
  }

  std::unique_ptr<EpochSink> sink(const NodeEpoch& key, Source& source, std::size_t piece) {
    if (!std::exchange(begun_, true)) write_notes();
    const NodeEpoch made{key.first, subset_epoch_number(key.second, words_, pieces_[piece])};
    source.open[piece] = made.second;
    Note origin = stamp_;
    origin.kind = NoteKind::kSubsetEpoch;
    origin.a = made.second;
    origin.b = key.second;
    record_.put(kNoteChannel, encode(origin));
    const auto put = [this, &source, piece, before = source.losses](const SealedBlock& block) {
      record_.put(block, losses_since(before, source.losses));
      holds_scans_ = holds_scans_ || block.kind == BlockKind::kScan;
      if (block.kind == BlockKind::kEnd) source.open.erase(piece);
    };
    std::unique_ptr<EpochSink> sink = std::make_unique<EpochWriter>(made, vehicle_of(source), put);
    for (const auto& [channel, data] :
         recorded_clocks_.events([&](const NodeEpoch& other) { return other == key; }))
      if (auto fit = decode_clock_fit(data)) {
        fit->epoch = made.second;
        record_.put(channel, encode(*fit));
      }
    if (request_.factor == 1) return sink;
    return make_reducing_sink(request_.factor, std::move(sink));
  }

  std::string vehicle_of(const Source& source) const {
    std::string text;
    for (const auto& [number, part] : source.vehicle) text += part;
    return subset_vehicle(text.empty() ? survey_.vehicle.text : text, request_.choice, request_.factor);
  }

  /// Before the first block: the description of this recording, and the state of the clocks.
  void write_notes() {
    stamp_.kind = NoteKind::kClock;
    for (const auto& [channel, data] : recorded_clocks_.events([](const NodeEpoch&) { return false; }))
      if (const auto note = decode_note(data)) stamp_ = *note;
    if (stamp_.time_us != 0) record_.put(kNoteChannel, encode(stamp_));
    Note note = stamp_;
    note.kind = NoteKind::kSubset;
    note.b = request_.factor;
    note.text = words_;
    record_.put(kNoteChannel, encode(note));
    constexpr std::size_t kMostPieces = 1000;
    for (std::size_t k = 0; k < std::min(pieces_.size(), kMostPieces); ++k) {
      note.a = static_cast<std::int64_t>(k) + 1;
      note.text = piece_words(pieces_[k], start_ns_);
      record_.put(kNoteChannel, encode(note));
    }
  }

  template <typename Message>
  void put_for_all(Message message, const std::string& channel) {
    const auto source = sources_.find({message.node, message.epoch});
    if (source == sources_.end()) return;
    for (const auto& [piece, epoch] : source->second.open) {
      message.epoch = epoch;
      record_.put(channel, encode(message));
    }
  }

  void take_journal(const LogEvent& event) {
    if (const auto entry = decode_journal(event.data))
      sources_[{entry->node, entry->epoch}].losses.raise(entry->node_losses);
  }

  // An absence is that of the new recording if it lies in a piece, even if it began before.
  void take_presence(const Note& note) {
    const auto number = static_cast<std::int32_t>(note.a);
    if (!is_chosen(number)) return;
    const auto missing = missing_.find(number);
    if (note.kind == NoteKind::kNodeMissing) {
      if (missing == missing_.end())
        missing_[number] = note;
      else
        missing->second.b = note.b;
      return;
    }
    if (missing == missing_.end()) return;
    if (note.b != 0 && lies_in_a_piece(missing->second, note.host_ns)) {
      record_.put(kNoteChannel, encode(missing->second));
      record_.put(kNoteChannel, encode(note));
    }
    missing_.erase(missing);
  }

  bool lies_in_a_piece(const Note& missing, std::int64_t to_ns) const {
    if (!survey_.notes_have_time()) return true;
    const std::size_t next = piece_from(pieces_, missing.host_ns);
    return next < pieces_.size() && pieces_[next].from_ns < to_ns;
  }

  bool is_chosen(std::int32_t number) const {
    const NodeConfig* node = survey_.vehicle.node_with_id(number);
    return node && chosen_channels(request_.choice, *node) != 0;
  }

  void take_note(const LogEvent& event) {
    const auto note = decode_note(event.data);
    if (!note) return;
    if (note->kind == NoteKind::kNodeMissing || note->kind == NoteKind::kNodeThere)
      return take_presence(*note);
    const NoteUse use = use_of(*note);
    const std::int64_t time_ns = survey_.notes_have_time() ? note->host_ns : last_sample_ns_;
    if (use == NoteUse::kAlways || (use == NoteUse::kOnceBegun && begun_) ||
        (use == NoteUse::kIfWanted && piece_at(pieces_, time_ns)))
      record_.put(event.channel, event.data);
  }

  const SubsetRequest& request_;
  const RecordingSurvey& survey_;
  const std::int64_t start_ns_;
  const Pieces& pieces_;
  const std::string words_;
  EpochClocks clocks_;
  RecordedClocks recorded_clocks_;
  SubsetRecord& record_;
  InSequence in_sequence_;
  std::map<NodeEpoch, Source> sources_;
  std::map<std::int32_t, Note> missing_;  // nodes that do not measure, since when
  Note stamp_;                            // the state of the clocks, for notes of this recording
  std::int64_t last_sample_ns_ = 0;
  std::int64_t refused_ = 0;
  bool begun_ = false, holds_scans_ = false;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
};

/// Bytes before each segment; behind the last one, of all.
std::map<int, std::uint64_t> bytes_before(const std::filesystem::path& folder) {
  std::map<int, std::uint64_t> before;
  std::uint64_t sum = 0;
  int last = 0;
  for (const int number : segment_numbers(folder)) {
    before[number] = sum;
    sum += size_of_file(segment_path(folder, number));
    last = number;
  }
  before[last + 1] = sum;
  return before;
}

void read_all(const SubsetRequest& request, Subset& subset, const std::stop_token& stop,
              const SubsetProgress& progress, SubsetReport& report) {
  RecordReader reader(request.folder);
  reader.finish();
  auto before = bytes_before(request.folder);
  const std::uint64_t all = before.rbegin()->second;
  constexpr unsigned kEventsBetween = 4096;
  for (unsigned count = 0; const auto event = reader.next(); ++count) {
    subset.take(*event);
    if (count % kEventsBetween != 0) continue;
    if (stop.stop_requested())
      throw std::runtime_error("stopped; nothing is left of " + request.output.string());
    if (progress) progress(before[reader.segment()] + reader.offset(), all);
  }
  subset.finish();
  report.defects.damaged_bytes = damaged_bytes(request.folder, reader);
  report.defects.refused_blocks = subset.refused_blocks();
  report.defects.missing_blocks = subset.missing_blocks();
}

std::uintmax_t bytes_of(const std::filesystem::path& folder) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) bytes += entry.file_size();
  return bytes;
}

}  // namespace

SubsetReport subset_recording(const SubsetRequest& request, std::stop_token stop,
                              const SubsetProgress& progress) {
  const RecordingSurvey survey = survey_recording(request.folder, stop);
  const ExportTable table = make_table(survey);
  check_choice(request.choice, survey.vehicle);
  const Pieces pieces = find_pieces(request, survey, table, stop);
  static_cast<void>(subset_vehicle(survey.vehicle.text, request.choice, request.factor));
  expect_beside({request.folder}, request.output);
  Part folder(request.output, Part::Kind::kFolder);
  expect_room(folder.place(), least_subset_bytes(request, survey, pieces));
  SubsetReport report;
  report.left_out = table.left_out;
  {
    SubsetRecord record(folder.part());
    Subset subset(request, survey, table, pieces, record);
    read_all(request, subset, stop, progress, report);
    record.close();
    report.made_of = subset.words();
    if (!subset.holds_scans()) throw ConfigError("--from, --to: no sample is left between them");
  }
  for (const Piece& piece : pieces)
    report.pieces.push_back(
        {piece.from_ns == std::numeric_limits<std::int64_t>::min() ? 0 : piece.from_ns - table.start_ns,
         piece.to_ns == Piece::kEver ? Piece::kEver : piece.to_ns - table.start_ns});
  report.verification = verify_record(folder.part());
  if (report.verification.verdict == Verdict::kDamaged || report.verification.verdict == Verdict::kUnreadable)
    throw std::runtime_error(request.output.string() + ": reads back otherwise than it was written");
  report.bytes = bytes_of(folder.part());
  folder.keep();
  return report;
}

}  // namespace roadbalance
