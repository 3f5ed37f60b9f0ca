#include "host/recorder/control/node_receipts.hpp"

#include <algorithm>
#include <system_error>

#include "common/record/folder.hpp"

namespace roadbalance {
namespace {

std::optional<bool> both(std::optional<bool> a, std::optional<bool> b) {
  if (a == false || b == false) return false;
  return a && b ? a : std::nullopt;
}

void add(const NodeReport& epoch, Receipt& receipt) {
  const bool has_end = epoch.ended && !epoch.crashed;  // the sum of a node that died is not known
  if (receipt.epochs == 0) receipt.sums_agree = true;
  if (has_end) receipt.sums_agree = both(receipt.sums_agree, epoch.sums_agree);
  ++receipt.epochs;
  if (!has_end) ++receipt.open_epochs;
  receipt.samples_sent += epoch.samples_sent;
  receipt.samples_recorded += epoch.samples_recorded;
  receipt.gaps += epoch.gaps;
  receipt.repaired += epoch.repaired;
  receipt.overload_s += epoch.overload_s;
  receipt.blocks_crc32c = epoch.blocks_crc32c;
}

}  // namespace

std::vector<Receipt> receipts_of(const RecorderReport& report, const RecordingFacts& facts) {
  std::map<std::int32_t, Receipt> by_node;
  for (const auto* epochs : {&report.earlier, &report.node})
    for (const NodeReport& epoch : *epochs) {
      // Heard, but never started: a node that was there in the end.  One that was started and fell silent at
      // once may have measured since, and its epoch is open.
      if (epoch.blocks == 0 && epoch.samples_sent == 0 && !epoch.started) continue;
      add(epoch, by_node[epoch.node]);
    }
  for (const Absence& absence : report.absence) {
    Receipt& receipt = by_node[absence.node];
    const bool may_be_cut_off = absence.to_end && absence.cause == AbsenceCause::kSilent;
    std::string& text = may_be_cut_off ? receipt.unheard : receipt.absence;
    text = words(absence) + (text.empty() ? "" : "; ") + text;  // the latest first: what is too long is cut
  }
  std::vector<Receipt> receipts;
  for (auto& [node, receipt] : by_node) {
    if (receipts.size() == kMostNodes) break;
    receipt.node = node;
    receipts.push_back(receipt);
  }
  if (receipts.empty()) receipts.emplace_back();
  const bool has_nodes = receipts.front().node != 0;
  for (std::size_t k = 0; k < receipts.size(); ++k) {
    Receipt& receipt = receipts[k];
    receipt.incarnation = facts.incarnation;
    receipt.began_us = facts.began_us;
    receipt.ended_us = facts.ended_us;
    receipt.index = static_cast<std::int32_t>(k);
    receipt.nodes = has_nodes ? static_cast<std::int32_t>(receipts.size()) : 0;
    receipt.bytes = facts.bytes;
    receipt.marks = facts.marks;
    receipt.name = facts.name;
    receipt.stopped_by = facts.stopped_by;
    if (const auto sync = facts.sync_us.find(receipt.node); sync != facts.sync_us.end())
      receipt.sync_us = sync->second;
  }
  return receipts;
}

// Overload and repairs of earlier runs are not in the folder; a node that died with its rest had sampled as
// much as it reported then, whatever the record has.
std::vector<Receipt> completed(const std::vector<Receipt>& before, const RecorderReport& report,
                               std::int64_t bytes) {
  const Receipt& old = before.front();
  auto receipts = receipts_of(report, {.name = old.name,
                                       .incarnation = old.incarnation,
                                       .began_us = old.began_us,
                                       .ended_us = old.ended_us,
                                       .bytes = bytes,
                                       .marks = old.marks,
                                       .stopped_by = old.stopped_by});
  for (Receipt& receipt : receipts) {
    const auto same = std::ranges::find(before, receipt.node, &Receipt::node);
    if (same == before.end()) continue;
    receipt.samples_sent = std::max(receipt.samples_sent, same->samples_sent);
    receipt.repaired = std::max(receipt.repaired, same->repaired);
    receipt.overload_s += same->overload_s;
    receipt.sync_us = same->sync_us;
    receipt.absence = same->absence;
    // It has sent its end since, and that was the stop.
    const auto ended_early = [&receipt](const NodeReport& epoch) {
      return epoch.node == receipt.node && epoch.ended_early;
    };
    if (receipt.open_epochs > 0 || std::ranges::any_of(report.node, ended_early))
      receipt.unheard = same->unheard;
    if (same->sums_agree == false) receipt.sums_agree = false;  // the folder has no sum then
  }
  if (receipts.front().nodes == 0) receipts.clear();  // the one that stands for no node
  // The folder holds nothing of a node that was never heard again: it is as open as it was.
  for (const Receipt& one : before)
    if (one.nodes > 0 && std::ranges::find(receipts, one.node, &Receipt::node) == receipts.end())
      receipts.push_back(one);
  if (receipts.empty()) return before;
  for (std::size_t k = 0; k < receipts.size(); ++k) {
    receipts[k].index = static_cast<std::int32_t>(k);
    receipts[k].nodes = static_cast<std::int32_t>(receipts.size());
    receipts[k].bytes = bytes;
  }
  return receipts;
}

std::int64_t bytes_of_folder(const std::filesystem::path& folder, Disk& disk) {
  std::int64_t bytes = 0;
  try {
    for (const std::string& name : list_folder(folder, disk)) {
      try {
        bytes += static_cast<std::int64_t>(size_of_file(folder / name, disk));
      } catch (const std::system_error&) {
      }
    }
  } catch (const std::system_error&) {
  }
  return bytes;
}

}  // namespace roadbalance
