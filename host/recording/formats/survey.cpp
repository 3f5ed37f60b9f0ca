#include "host/recording/formats/survey.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record_reader.hpp"
#include "common/types/bounded_time.hpp"
#include "host/recording/in_sequence.hpp"
#include "host/recording/manifest.hpp"
#include "host/recording/preamble.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "host/recording/set_clocks.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kMostSpans = 10'000;

class Surveyor {
 public:
  Surveyor(const std::filesystem::path& folder, RecordingSurvey& found)
      : found_(found), in_sequence_(InSequence::of_record(folder)) {}

  void take(const LogEvent& event) {
    if (event.channel.starts_with(kBlockChannels)) return take_block(event);
    if (const auto fit = clocks_.take(event.channel, event.data)) take_fit(*fit);
    if (event.channel != kNoteChannel) return;
    const auto note = decode_note(event.data);
    if (note) set_clocks_.take(*note);
    if (note && note->kind == NoteKind::kImported) found_.imported = true;
    if (!note || note->kind != NoteKind::kMark) return;
    // A recorder that was killed may have noted it before: it is noted again under the same number.
    if (mark_number_.contains(note->a)) return;
    if (found_.mark.size() < RecordingSurvey::kMostMarks) {
      mark_number_.insert(note->a);
      found_.mark.push_back({note->host_ns, last_sample_ns_, note->a, note->text});
    } else {
      ++found_.marks_left_out;
    }
  }

  void finish() {
    found_.defects.missing_blocks = in_sequence_.missing();
    std::optional<std::int64_t> first_ns;
    for (const auto& span : found_.span)
      if (span.first_fit) first_ns = std::min(first_ns.value_or(span.first_host_ns()), span.first_host_ns());
    const auto utc_us = first_ns ? clocks_.utc_us(*first_ns) : std::nullopt;
    if (!utc_us && begins_at_) found_.start_utc_us = set_clocks_.utc_us(*begins_at_);
    if (!utc_us) return;
    found_.start_utc_us = utc_us;
    found_.start_by_clock = true;
  }

 private:
  void take_block(const LogEvent& event) {
    if (accept(event, *block_) != Refusal::kNone) {
      ++found_.defects.refused_blocks;
      return;
    }
    in_sequence_.add(*block_, [&](const SealedBlock& block) {
      const bool scans = block.kind == BlockKind::kScan;
      if ((scans || block.kind == BlockKind::kGap) && block.header.scans > 0) add(block, event, scans);
    });
  }

  void add(const SealedBlock& block, const LogEvent& event, bool scans) {
    const BlockHeader& header = block.header;
    const NodeEpoch key{header.node, header.epoch};
    auto at = place_.find(key);
    if (at == place_.end()) {
      if (!scans) return;  // an epoch begins with its first sample
      if (found_.span.size() == kMostSpans) throw std::runtime_error("more node epochs than can be exported");
      at = place_.emplace(key, found_.span.size()).first;
      begin(header, summary_of(block).period_ps, event);
    }
    RecordedSpan& span = found_.span[at->second];
    const std::int64_t next = header.first_scan + header.scans;
    if (next > span.next_scan) {
      if (scans) span.samples += header.scans;
      span.last_ns = scans ? time_after_ns(header.time_ns, header.scans, span.period_ps)
                           : time_after_ns(span.last_ns, next - span.next_scan, span.period_ps);
      span.next_scan = next;
      span.last_host_ns = clocks_.host_ns(key, span.last_ns).value_or(span.last_ns);
    }
    if (scans) span.overload |= summary_of(block).overload;
    last_sample_ns_ = span.last_ns;
  }

  void begin(const BlockHeader& header, std::int64_t period_ps, const LogEvent& event) {
    RecordedSpan span{.node = header.node, .epoch = header.epoch};
    span.first_scan = span.next_scan = header.first_scan;
    span.period_ps = period_ps;
    span.first_ns = span.last_ns = header.time_ns;
    const auto fit = early_fit_.find({header.node, header.epoch});
    if (fit != early_fit_.end()) span.first_fit = fit->second;
    found_.span.push_back(span);
    if (!begins_at_ && event.timestamp_us > 0 && event.timestamp_us <= kUtcLimit_us)
      begins_at_ = set_clocks_.stamp(event.timestamp_us);
  }

  void take_fit(const ClockFit& fit) {
    if (!fit.is_known()) return;
    const NodeEpoch key{fit.node, fit.epoch};
    const auto at = place_.find(key);
    if (at == place_.end()) {
      if (early_fit_.size() < kMostSpans) early_fit_.try_emplace(key, fit);
      return;
    }
    RecordedSpan& span = found_.span[at->second];
    if (!span.first_fit) span.first_fit = fit;
    span.last_host_ns = host_instant_ns(fit, span.last_ns);
  }

  RecordingSurvey& found_;
  RecordedClocks clocks_;
  SetClocks set_clocks_;
  std::optional<SetClocks::Stamp> begins_at_;  ///< of the first epoch
  InSequence in_sequence_;
  std::map<NodeEpoch, std::size_t> place_;   ///< in found_.span
  std::map<NodeEpoch, ClockFit> early_fit_;  ///< of epochs without a sample so far
  std::set<std::int64_t> mark_number_;       ///< of found_.mark
  std::int64_t last_sample_ns_ = 0;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
};

}  // namespace

RecordingSurvey survey_recording(const std::filesystem::path& folder, std::stop_token stop) {
  RecordReader reader(folder);
  RecordingSurvey found{.vehicle = vehicle_of_recording(folder)};
  if (const auto description = read_description(folder)) found.program = description->program;
  reader.finish();
  Surveyor surveyor(folder, found);
  while (const auto event = reader.next()) {
    surveyor.take(*event);
    if (stop.stop_requested()) throw std::runtime_error("stopped");
  }
  found.defects.damaged_bytes = damaged_bytes(folder, reader);
  surveyor.finish();
  if (found.span.empty()) throw std::runtime_error(folder.string() + ": holds no sample");
  return found;
}

}  // namespace roadbalance
