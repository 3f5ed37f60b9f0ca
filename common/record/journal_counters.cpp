#include "common/record/journal_counters.hpp"

#include "common/bus/codec.hpp"
#include "common/types/crc32c.hpp"

namespace roadbalance {
namespace {

// The entry that follows: it begins where this one ends.
Journal next_entry(const Journal& before) {
  return {.node = before.node,
          .epoch = before.epoch,
          .first_sequence = before.last_sequence + 1,
          .last_sequence = before.last_sequence,
          .first_scan = before.next_scan,
          .next_scan = before.next_scan};
}

bool is_empty(const Journal& journal) {
  return journal.last_sequence < journal.first_sequence;
}

}  // namespace

void JournalCounters::add(const SealedBlock& block) {
  const BlockHeader& header = block.header;
  if (header.sequence <= 0) return;
  Journal& journal = open_[{header.node, header.epoch}];
  const bool is_first = journal.node == 0;
  journal.node = header.node;
  journal.epoch = header.epoch;
  // A recorder that continues a record begins in the middle of an epoch; a gap may cover numbers before its
  // own.
  const bool covers_those_before =
      block.kind == BlockKind::kGap && stands_for_lost_blocks(decode_gap(block).cause);
  if (is_empty(journal) && (is_first || !covers_those_before)) journal.first_sequence = header.sequence;
  journal.last_sequence = header.sequence;
  if (block.kind != BlockKind::kScan && block.kind != BlockKind::kGap) return;
  if (journal.scans == 0 && journal.scans_missing == 0) journal.first_scan = header.first_scan;
  journal.next_scan = header.first_scan + header.scans;
  (block.kind == BlockKind::kScan ? journal.scans : journal.scans_missing) += header.scans;
  if (block.kind == BlockKind::kScan) crc32c_columns(encoded_counts(block), journal.channel_crc);
}

Journal JournalCounters::take(std::int32_t node, std::int64_t epoch) {
  Journal& open = open_[{node, epoch}];
  open.node = node;
  open.epoch = epoch;
  const Journal done = open;
  open = next_entry(done);
  return done;
}

std::vector<NodeEpoch> JournalCounters::due() const {
  std::vector<NodeEpoch> keys;
  for (const auto& [key, journal] : open_)
    if (!is_empty(journal)) keys.push_back(key);
  return keys;
}

}  // namespace roadbalance
