#include "host/recording/verify/verify_journal.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace roadbalance {
namespace {

std::string range(std::int64_t first, std::int64_t last) {
  return last < first ? "no blocks" : "blocks " + std::to_string(first) + " to " + std::to_string(last);
}

std::vector<std::pair<const char*, std::int64_t>> counts_of(const JournalCheck::Losses& l) {
  std::vector<std::pair<const char*, std::int64_t>> counts;
  NodeLosses::list_counts([&counts](const char* name, auto count) { counts.emplace_back(name, count); },
                          l.node);
  // Before those of the devices, which are many.
  counts.insert(counts.end() - kDeviceCounters, {{"refused", l.refused},
                                                 {"rivals", l.rivals},
                                                 {"unsent", l.unsent},
                                                 {"disk_failures", l.disk_failures}});
  return counts;
}

}  // namespace

void JournalCheck::count_losses(const Journal& entry) {
  const NodeEpoch key{entry.node, entry.epoch};
  const Losses counted{.node = entry.node_losses,
                       .refused = entry.refused,
                       .rivals = entry.rivals,
                       .unsent = entry.unsent,
                       .disk_failures = entry.disk_failures};
  const auto now = counts_of(counted), before = counts_of(counted_[key]);
  for (std::size_t k = 0; k < now.size(); ++k)
    if (now[k].second < before[k].second)
      contradictions_[key].push_back(std::string("the journal's count of ") + now[k].first +
                                     " goes down, from " + std::to_string(before[k].second) + " to " +
                                     std::to_string(now[k].second));
  counted_[key] = counted;
  // A recorder that began anew may not have heard the node yet.
  NodeLosses known = losses_[key].node;
  losses_[key] = counted;
  known.raise(counted.node);
  losses_[key].node = known;
}

bool JournalCheck::begins_before(const Journal& entry) const {
  const auto before = before_.find({entry.node, entry.epoch});
  return before != before_.end() && entry.first_sequence <= before->second.position.contiguous;
}

void JournalCheck::nothing_was_deleted() {
  for (auto& [key, found] : unless_deleted_)
    std::ranges::move(found, std::back_inserter(contradictions_[key]));
  unless_deleted_.clear();
}

void JournalCheck::add(const Journal& entry) {
  ++entries_;
  count_losses(entry);
  const NodeEpoch key{entry.node, entry.epoch};
  const Journal found = since_entry_.take(entry.node, entry.epoch);
  const bool lists_none = entry.last_sequence < entry.first_sequence;
  const bool found_none = found.last_sequence < found.first_sequence;
  // An entry without scans stands where the one before ends, which may have gone with its segment.
  const bool has_scans = found.scans + found.scans_missing > 0;
  const std::string where = "journal entry of " + range(entry.first_sequence, entry.last_sequence) + ": ";
  auto& of_epochs = begins_before(entry) ? unless_deleted_ : contradictions_;
  auto& contradictions = of_epochs[key];
  const bool same_blocks =
      entry.first_sequence == found.first_sequence && entry.last_sequence == found.last_sequence;
  if (!same_blocks && !(lists_none && found_none))
    contradictions.push_back(where + "here are " + range(found.first_sequence, found.last_sequence));
  else if (entry.scans != found.scans || entry.scans_missing != found.scans_missing)
    contradictions.push_back(where + std::to_string(entry.scans) + " scans and " +
                             std::to_string(entry.scans_missing) + " missing, here are " +
                             std::to_string(found.scans) + " and " + std::to_string(found.scans_missing));
  else if (has_scans && (entry.first_scan != found.first_scan || entry.next_scan != found.next_scan))
    contradictions.push_back(where + "scans " + std::to_string(entry.first_scan) + " to " +
                             std::to_string(entry.next_scan - 1) + ", here are " +
                             std::to_string(found.first_scan) + " to " + std::to_string(found.next_scan - 1));
  else if (entry.channel_crc != found.channel_crc)
    contradictions.push_back(where + "the scans here are others");
  if (contradictions.empty()) of_epochs.erase(key);
}

}  // namespace roadbalance
