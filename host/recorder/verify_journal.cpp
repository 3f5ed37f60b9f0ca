#include "host/recorder/verify_journal.hpp"

namespace roadbalance {
namespace {

std::string range(std::int64_t first, std::int64_t last) {
  return last < first ? "no blocks" : "blocks " + std::to_string(first) + " to " + std::to_string(last);
}

}  // namespace

void JournalCheck::add(const Journal& entry) {
  ++entries_;
  const NodeEpoch key{entry.node, entry.epoch};
  const Journal found = tally_.take(entry.node, entry.epoch);
  const bool said_none = entry.last_sequence < entry.first_sequence;
  const bool found_none = found.last_sequence < found.first_sequence;
  if (said_none && found_none) return;
  const auto deleted = deleted_.find(key);
  if (deleted != deleted_.end() && entry.first_sequence <= deleted->second.position.contiguous) return;
  const std::string where = "journal entry of " + range(entry.first_sequence, entry.last_sequence) + ": ";
  auto& contradictions = contradictions_[key];
  if (entry.first_sequence != found.first_sequence || entry.last_sequence != found.last_sequence)
    contradictions.push_back(where + "here are " + range(found.first_sequence, found.last_sequence));
  else if (entry.scans != found.scans || entry.scans_missing != found.scans_missing ||
           entry.next_scan != found.next_scan)
    contradictions.push_back(where + std::to_string(entry.scans) + " scans and " +
                             std::to_string(entry.scans_missing) + " missing, here are " +
                             std::to_string(found.scans) + " and " + std::to_string(found.scans_missing));
  else if (entry.channel_crc != found.channel_crc)
    contradictions.push_back(where + "the scans here are others");
  if (contradictions.empty()) contradictions_.erase(key);
}

}  // namespace roadbalance
