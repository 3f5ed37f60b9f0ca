#include "host/recorder/store_journal.hpp"

#include <algorithm>

namespace roadbalance {

std::vector<NodeEpoch> StoreJournal::due(bool with_losses) const {
  std::vector<NodeEpoch> due = blocks_.due();
  if (!with_losses) return due;
  for (const auto& [key, losses] : last_losses_)
    if (const auto node = counters_.node.find(key);
        node != counters_.node.end() && node->second != losses && std::ranges::find(due, key) == due.end())
      due.push_back(key);
  return due;
}

std::vector<Journal> StoreJournal::entries(bool with_losses, std::int64_t time_us,
                                           std::int64_t disk_failures) {
  std::vector<Journal> entries;
  for (const NodeEpoch& key : due(with_losses)) {
    Journal entry = blocks_.take(key.first, key.second);
    entry.time_us = time_us;
    if (const auto node = counters_.node.find(key); node != counters_.node.end())
      entry.node_losses = node->second;
    last_losses_[key] = entry.node_losses;
    entry.refused = counters_.refused;
    entry.rivals = counters_.rivals;
    entry.unsent = counters_.unsent;
    entry.disk_failures = disk_failures;
    entries.push_back(std::move(entry));
  }
  return entries;
}

void StoreJournal::begin_anew() {
  blocks_ = {};
  last_losses_.clear();
}

}  // namespace roadbalance
