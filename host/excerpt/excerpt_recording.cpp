#include "host/excerpt/excerpt_recording.hpp"

#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/record/folder.hpp"
#include "common/record/part.hpp"
#include "common/record/room.hpp"
#include "common/record/segment.hpp"
#include "host/analyser/in_sequence.hpp"
#include "host/excerpt/epoch_clocks.hpp"
#include "host/excerpt/epoch_writer.hpp"
#include "host/excerpt/excerpt_epoch.hpp"
#include "host/excerpt/excerpt_notes.hpp"
#include "host/excerpt/excerpt_record.hpp"
#include "host/excerpt/excerpt_words.hpp"
#include "host/excerpt/find_pieces.hpp"
#include "host/excerpt/least_bytes.hpp"
#include "host/excerpt/reducing_sink.hpp"
#include "host/recorder/continued_folders.hpp"
#include "host/recorder/manifest.hpp"

namespace roadbalance {
namespace {

class Excerpt {
 public:
  Excerpt(const ExcerptRequest& request, const RecordingSurvey& survey, const ExportTable& table,
          const Pieces& pieces, ExcerptRecord& record)
      : request_(request),
        survey_(survey),
        start_ns_(table.start_ns),
        pieces_(pieces),
        words_(excerpt_words(request)),
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
    std::map<std::int32_t, std::string> vehicle;  ///< parts of its text
    std::unique_ptr<ExcerptEpoch> epoch;          ///< nothing: not wanted
    std::map<std::size_t, std::int64_t> open;     ///< numbers of the epochs that are made of it now, by piece
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

  std::unique_ptr<ExcerptEpoch> begin(const NodeEpoch& key, Source& source, std::int64_t period_ps) {
    const NodeConfig* node = survey_.vehicle.node_with_id(key.first);
    const EpochClock* clock = clocks_.of(key);
    const std::uint32_t chosen = node && clock ? chosen_channels(request_.choice, *node) : 0;
    if (chosen == 0) return nullptr;
    for (const RecordedSpan& span : survey_.span)
      if (NodeEpoch{span.node, span.epoch} == key) period_ps = span.period_ps;
    const std::uint32_t kept = request_.choice.channels.empty() ? ~0U : chosen;
    return std::make_unique<ExcerptEpoch>(
        *clock, pieces_, period_ps, kept,
        [this, key, &source](std::size_t piece) { return sink(key, source, piece); });
  }

  std::unique_ptr<EpochSink> sink(const NodeEpoch& key, Source& source, std::size_t piece) {
    if (!std::exchange(begun_, true)) write_notes();
    const NodeEpoch made{key.first, excerpt_epoch_number(key.second, words_, pieces_[piece])};
    source.open[piece] = made.second;
    Note origin = stamp_;
    origin.kind = NoteKind::kExcerptEpoch;
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
    return std::make_unique<ReducingSink>(request_.factor, std::move(sink));
  }

  std::string vehicle_of(const Source& source) const {
    std::string text;
    for (const auto& [number, part] : source.vehicle) text += part;
    return excerpt_vehicle(text.empty() ? survey_.vehicle.text : text, request_.choice, request_.factor);
  }

  /// Before the first block: what this is, and how the clocks stand.
  void write_notes() {
    stamp_.kind = NoteKind::kClock;
    for (const auto& [channel, data] : recorded_clocks_.events([](const NodeEpoch&) { return false; }))
      if (const auto note = decode_note(data)) stamp_ = *note;
    if (stamp_.time_us != 0) record_.put(kNoteChannel, encode(stamp_));
    Note note = stamp_;
    note.kind = NoteKind::kExcerpt;
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

  void take_note(const LogEvent& event) {
    const auto note = decode_note(event.data);
    if (!note) return;
    const NoteGoes goes_so = goes(*note);
    const std::int64_t time_ns = survey_.notes_tell_time() ? note->host_ns : last_sample_ns_;
    if (goes_so == NoteGoes::kAlways || (goes_so == NoteGoes::kWithIt && begun_) ||
        (goes_so == NoteGoes::kAlong && piece_at(pieces_, time_ns)))
      record_.put(event.channel, event.data);
  }

  const ExcerptRequest& request_;
  const RecordingSurvey& survey_;
  const std::int64_t start_ns_;
  const Pieces& pieces_;
  const std::string words_;
  EpochClocks clocks_;
  RecordedClocks recorded_clocks_;
  ExcerptRecord& record_;
  InSequence in_sequence_;
  std::map<NodeEpoch, Source> sources_;
  Note stamp_;  // how the clocks stand, for notes of this excerpt
  std::int64_t last_sample_ns_ = 0;
  std::int64_t refused_ = 0;
  bool begun_ = false, holds_scans_ = false;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
};

/// Bytes of the segments before each, and of all behind the last.
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

void read_all(const ExcerptRequest& request, Excerpt& excerpt, const std::stop_token& stop,
              const ExcerptProgress& progress, ExcerptReport& report) {
  RecordReader reader(request.folder);
  reader.finish();
  auto before = bytes_before(request.folder);
  const std::uint64_t all = before.rbegin()->second;
  constexpr unsigned kEventsBetween = 4096;
  for (unsigned count = 0; const auto event = reader.next(); ++count) {
    excerpt.take(*event);
    if (count % kEventsBetween != 0) continue;
    if (stop.stop_requested())
      throw std::runtime_error("stopped; nothing is left of " + request.output.string());
    if (progress) progress(before[reader.segment()] + reader.offset(), all);
  }
  excerpt.finish();
  report.defects.damaged_bytes = damaged_bytes(request.folder, reader);
  report.defects.refused_blocks = excerpt.refused_blocks();
  report.defects.missing_blocks = excerpt.missing_blocks();
}

std::uintmax_t bytes_of(const std::filesystem::path& folder) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) bytes += entry.file_size();
  return bytes;
}

}  // namespace

ExcerptReport excerpt_recording(const ExcerptRequest& request, std::stop_token stop,
                                const ExcerptProgress& progress) {
  const RecordingSurvey survey = survey_recording(request.folder, stop);
  const ExportTable table = make_table(survey);
  check_choice(request.choice, survey.vehicle);
  const Pieces pieces = find_pieces(request, survey, table, stop);
  static_cast<void>(excerpt_vehicle(survey.vehicle.text, request.choice, request.factor));
  expect_beside({request.folder}, request.output);
  Part folder(request.output, Part::Kind::kFolder);
  expect_room(folder.place(), least_excerpt_bytes(request, survey, pieces));
  ExcerptReport report;
  report.left_out = table.left_out;
  {
    ExcerptRecord record(folder.part());
    Excerpt excerpt(request, survey, table, pieces, record);
    read_all(request, excerpt, stop, progress, report);
    record.close();
    report.made_of = excerpt.words();
    if (!excerpt.holds_scans()) throw ConfigError("--from, --to: no sample is left between them");
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
