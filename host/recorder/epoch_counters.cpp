#include "host/recorder/epoch_counters.hpp"

#include <algorithm>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

NodeLosses losses_of(const Heartbeat& heard) {
  return {.repaired = heard.blocks_repaired,
          .spool_failures = heard.spool_failures,
          .scans_refused = heard.scans_refused,
          .blocks_unsent = heard.blocks_unsent,
          .acks_refused = heard.acks_refused,
          .encoder_faults = heard.encoder_faults,
          .unreferenced_blocks = heard.unreferenced_blocks,
          .device_counts = heard.device_counts};
}

}  // namespace

EpochCounters::EpochCounters(const RecordState& recovered) : sums_(recovered) {
  for (const auto& [key, epoch] : recovered.epoch) {
    counts_[key] = {.node = key.first,
                    .epoch = key.second,
                    // Scans that the record lacks were sent all the same.
                    .samples_sent = std::max(epoch.samples, epoch.position.next_scan),
                    .samples_recorded = epoch.samples,
                    .gaps = epoch.gaps,
                    .blocks = epoch.blocks,
                    .ended = epoch.position.ended,
                    .crashed = epoch.position.crashed,
                    .has_durable_samples = epoch.samples > 0,
                    .blocks_crc32c = epoch.sum.value_or(0),
                    .sums_agree = epoch.position.ended && epoch.sum ? std::optional(true) : std::nullopt};
  }
}

NodeReport& EpochCounters::of(std::int32_t node, std::int64_t epoch) {
  NodeReport& report = counts_[{node, epoch}];
  report.node = node;
  report.epoch = epoch;
  return report;
}

void EpochCounters::take(const Heartbeat& heartbeat) {
  const NodeEpoch key{heartbeat.node, heartbeat.epoch};
  if (std::find(heard_.begin(), heard_.end(), key) == heard_.end()) heard_.push_back(key);
  NodeReport& report = of(heartbeat.node, heartbeat.epoch);
  report.samples_sent = std::max(report.samples_sent, heartbeat.scans_sampled);
  NodeLosses& losses = losses_[key];
  losses.raise(losses_of(heartbeat));  // an old heartbeat may come behind a newer one
  // The node's own count: what is asked for may be new, and on its way anyway.
  report.repaired = losses.repaired;
}

void EpochCounters::take(const Delivery& delivery) {
  if (const auto* gap = std::get_if<GapBlock>(&delivery)) {
    sums_.lose({gap->header.node, gap->header.epoch});
    NodeReport& report = of(gap->header.node, gap->header.epoch);
    ++report.gaps;
    ++report.blocks;
    report.crashed = report.crashed || gap->cause == GapCause::kNodeCrash;
    report.ended = report.ended || report.crashed;
    return;
  }
  const auto& block = std::get<SealedBlock>(delivery);
  NodeReport& report = of(block.header.node, block.header.epoch);
  ++report.blocks;
  if (block.kind == BlockKind::kGap) ++report.gaps;
  if (block.kind == BlockKind::kScan) {
    report.samples_recorded += block.header.scans;
    // A node that dies has not counted the last of them in a heartbeat.
    report.samples_sent = std::max(report.samples_sent, block.header.first_scan + block.header.scans);
    if (report.first_scan_block == 0) report.first_scan_block = block.header.sequence;
    if (const ScanSummary scans = summary_of(block); scans.overload != 0)
      report.overload_s +=
          1e-12 * static_cast<double>(scans.period_ps) * static_cast<double>(block.header.scans);
  }
  sums_.take(block);
  if (block.kind == BlockKind::kEnd) {
    const EndBlock end = decode_end(block);
    report.samples_sent = std::max(end.scans_sealed + end.scans_missing, report.samples_recorded);
    report.ended = true;
    report.blocks_crc32c = end.blocks_crc32c;
    report.sums_agree = sums_.agrees(block);
  }
}

RecorderReport EpochCounters::report() const {
  RecorderReport report;
  for (const auto& key : heard_) report.node.push_back(counts_.at(key));
  for (const auto& [key, count] : counts_)
    if (std::find(heard_.begin(), heard_.end(), key) == heard_.end()) report.earlier.push_back(count);
  std::stable_sort(report.node.begin(), report.node.end(),
                   [](const NodeReport& a, const NodeReport& b) { return a.node < b.node; });
  return report;
}

}  // namespace roadbalance
