#include "host/recorder/tally.hpp"

#include <algorithm>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

void raise(std::int64_t& count, std::int64_t heard) {
  count = std::max(count, heard);
}

// Counts only rise; an old heartbeat may come behind a newer one.
void raise(NodeLosses& losses, const Heartbeat& heard) {
  raise(losses.repaired, heard.blocks_repaired);
  raise(losses.spool_failures, heard.spool_failures);
  raise(losses.scans_refused, heard.scans_refused);
  raise(losses.blocks_unsent, heard.blocks_unsent);
  raise(losses.acks_refused, heard.acks_refused);
  for (std::size_t line = 0; line < losses.encoder_faults.size(); ++line)
    raise(losses.encoder_faults[line], heard.encoder_faults[line]);
  raise(losses.unreferenced_blocks, heard.unreferenced_blocks);
  for (std::size_t k = 0; k < kDeviceCounters; ++k) raise(losses.device_counts[k], heard.device_counts[k]);
}

}  // namespace

Tally::Tally(const RecordState& recovered) {
  for (const auto& [key, epoch] : recovered.epoch)
    counts_[key] = {.node = key.first,
                    .epoch = key.second,
                    .samples_sent = epoch.samples,
                    .samples_recorded = epoch.samples,
                    .gaps = epoch.gaps,
                    .blocks = epoch.blocks,
                    .ended = epoch.position.ended};
}

NodeReport& Tally::of(std::int32_t node, std::int64_t epoch) {
  NodeReport& report = counts_[{node, epoch}];
  report.node = node;
  report.epoch = epoch;
  return report;
}

void Tally::take(const Heartbeat& heartbeat) {
  const NodeEpoch key{heartbeat.node, heartbeat.epoch};
  if (std::find(heard_.begin(), heard_.end(), key) == heard_.end()) heard_.push_back(key);
  NodeReport& report = of(heartbeat.node, heartbeat.epoch);
  report.samples_sent = std::max(report.samples_sent, heartbeat.scans_sampled);
  NodeLosses& losses = losses_[key];
  raise(losses, heartbeat);
  // The node's own count: what is asked for may be new, and on its way anyway.
  report.repaired = losses.repaired;
}

void Tally::take(const Delivery& delivery) {
  if (const auto* gap = std::get_if<GapBlock>(&delivery)) {
    NodeReport& report = of(gap->header.node, gap->header.epoch);
    ++report.gaps;
    ++report.blocks;
    report.ended = report.ended || gap->cause == GapCause::kNodeCrash;
    return;
  }
  const auto& block = std::get<SealedBlock>(delivery);
  NodeReport& report = of(block.header.node, block.header.epoch);
  ++report.blocks;
  if (block.kind == BlockKind::kGap) ++report.gaps;
  if (block.kind == BlockKind::kScan) report.samples_recorded += block.header.scans;
  if (block.kind == BlockKind::kEnd) {
    const EndBlock end = decode_end(block);
    report.samples_sent = end.scans_sealed + end.scans_missing;
    report.ended = true;
  }
}

RecorderReport Tally::report() const {
  RecorderReport report;
  for (const auto& key : heard_) report.node.push_back(counts_.at(key));
  std::stable_sort(report.node.begin(), report.node.end(),
                   [](const NodeReport& a, const NodeReport& b) { return a.node < b.node; });
  return report;
}

}  // namespace roadbalance
