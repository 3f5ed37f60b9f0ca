#include "host/recordings/recording_summary.hpp"

#include <algorithm>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <system_error>

#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/notes.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/record/record_reader.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "host/recording/set_clocks.hpp"
#include "host/recording/subset/reduction.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

/// Facts that verify_record() does not collect.
struct Survey {
  std::map<std::int32_t, double> overload_s, sync_residual_s;  ///< by node
  SetClocks clocks;
  SetClocks::Stamp first{}, last{};
  std::vector<RecordingSummary::Mark> mark;
  std::vector<SetClocks::Stamp> marked;  // each mark
  std::set<std::int64_t> mark_number;
};

void take(const LogEvent& event, SealedBlock& block, Survey& found) {
  if (event.timestamp_us > 0) {  // descriptions before the first block have none
    found.last = found.clocks.stamp(event.timestamp_us);
    if (found.first.utc_us == 0) found.first = found.last;
  }
  if (event.channel == kNoteChannel) {
    const auto note = decode_note(event.data);
    if (note) found.clocks.take(*note);
    // A recorder that was killed may have noted it before: it is noted again under the same number.
    if (note && note->kind == NoteKind::kMark && found.mark_number.insert(note->a).second) {
      found.mark.push_back({note->time_us, note->text, static_cast<std::int32_t>(note->a)});
      found.marked.push_back(found.clocks.stamp(note->time_us));
    }
  } else if (const auto fit = decode_clock_fit(event.data)) {
    double& worst = found.sync_residual_s.try_emplace(fit->node, -1.0).first->second;
    if (fit->is_known()) worst = std::max(worst, fit->uncertainty_s);
  } else if (event.channel.ends_with("_SCAN") && accept(event, block) == Refusal::kNone) {
    const ScanBlock scans = decode_scan(block);
    if (scans.overload != 0)
      found.overload_s[block.header.node] +=
          static_cast<double>(block.header.scans) * static_cast<double>(scans.period_ps) * 1e-12;
  }
}

Survey survey(const std::filesystem::path& folder) {
  Survey found;
  RecordReader reader(folder);
  reader.finish();
  const auto block = std::make_unique<SealedBlock>();
  while (const auto event = reader.next()) take(*event, *block, found);
  for (std::size_t k = 0; k < found.mark.size(); ++k)
    found.mark[k].time_us = found.clocks.utc_us(found.marked[k]);
  return found;
}

RecordingState state_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kComplete:
      return RecordingState::kComplete;
    case Verdict::kDamaged:
      return RecordingState::kDamaged;
    case Verdict::kIncomplete:
      return RecordingState::kIncomplete;
    case Verdict::kUnreadable:
      break;
  }
  return RecordingState::kUnreadable;
}

void put_nodes(const Verification& proof, const Survey& found, RecordingSummary& summary) {
  std::map<std::int32_t, RecordingSummary::Node> nodes;
  for (const VerifiedEpoch& epoch : proof.epoch) {
    RecordingSummary::Node& node = nodes[epoch.node];
    node.node = epoch.node;
    node.samples += epoch.samples;
    node.samples_lost += epoch.samples_missing;
    for (const MissingSpan& span : epoch.undeclared_scans) node.samples_lost += span.last - span.first + 1;
    node.repaired += epoch.losses.repaired;
    node.seconds += static_cast<double>(epoch.samples) * static_cast<double>(epoch.period_ps) * 1e-12;
  }
  for (const Verification::Absent& absent : proof.absent) {
    nodes[absent.node].node = absent.node;
    nodes[absent.node].absent = true;
  }
  for (auto& [id, node] : nodes) {
    if (const auto overload = found.overload_s.find(id); overload != found.overload_s.end())
      node.overload_s = overload->second;
    if (const auto sync = found.sync_residual_s.find(id); sync != found.sync_residual_s.end())
      node.sync_residual_s = sync->second;
    summary.node.push_back(node);
  }
}

void put_vehicle(const std::filesystem::path& folder, RecordingSummary& summary) {
  try {
    const auto vehicle = recorded_vehicle(folder);
    if (!vehicle) return;
    summary.vehicle = vehicle->name;
    summary.rate_hz = vehicle->node.front().rate_hz;
    summary.cutoff_hz = vehicle->filter.cutoff_hz;
    // rb reduce uses the rate in the file, which differs from the fitted rate of an import.
    summary.most_reduction = largest_reduction(VehicleConfig::parse(vehicle->text, "vehicle.toml"));
  } catch (const std::exception&) {
    // A recording without a usable vehicle.toml is listed all the same.
  }
}

}  // namespace

RecordingSummary unread(const std::filesystem::path& folder) {
  RecordingSummary summary{
      .name = folder.filename().string(), .vehicle = "", .place = folder.parent_path().string()};
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    const auto size = entry.is_regular_file(ignored) ? entry.file_size(ignored) : 0;
    if (!ignored) summary.bytes += static_cast<std::int64_t>(size);
  }
  return summary;
}

RecordingSummary summary_of(const std::filesystem::path& folder) {
  return summary_of(folder, verify_record(folder));
}

RecordingSummary summary_of(const std::filesystem::path& folder, const Verification& proof) {
  RecordingSummary summary = unread(folder);
  summary.state = state_of(proof.verdict);
  if (proof.verdict == Verdict::kUnreadable) {
    summary.verdict = proof.error;
    return summary;
  }
  summary.verdict = verdict_text(proof);
  summary.refused = proof.blocks_refused + proof.entries_refused;
  summary.damaged_bytes = static_cast<std::int64_t>(proof.damaged_bytes);
  put_vehicle(folder, summary);
  try {
    Survey found = survey(folder);
    summary.first_us = found.clocks.utc_us(found.first);
    summary.last_us = found.clocks.utc_us(found.last);
    put_nodes(proof, found, summary);
    summary.marks = static_cast<std::int32_t>(found.mark.size());
    summary.mark = std::move(found.mark);
  } catch (const std::exception& error) {  // it has vanished meanwhile
    summary.state = RecordingState::kUnreadable;
    summary.verdict = error.what();
  }
  return summary;
}

}  // namespace roadbalance
