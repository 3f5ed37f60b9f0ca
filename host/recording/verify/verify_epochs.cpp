#include "host/recording/verify/verify_epochs.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

// A block behind a declared loss of unknown length.
constexpr std::int64_t kUnknownScan = -1;

// Its first scan follows the last one before it.
bool counts_scans(BlockKind kind) {
  return kind == BlockKind::kScan || kind == BlockKind::kGap || kind == BlockKind::kEnd;
}

std::uint32_t crc_of(const SealedBlock& block) {
  std::uint32_t crc = 0;
  for (const std::uint8_t byte : block.bytes().last(4)) crc = crc << 8 | byte;
  return crc;
}

bool ends_its_epoch(const BlockEntry& entry) {
  return entry.kind == BlockKind::kEnd ||
         (entry.kind == BlockKind::kGap && entry.cause == GapCause::kNodeCrash);
}

}  // namespace

void EpochCheck::begin_behind(const std::map<NodeEpoch, RecordState::Epoch>& deleted) {
  for (const auto& [key, epoch] : deleted) find_or_add(key).deleted = epoch;
  // Epochs without any block here appeared before all others.
  std::stable_partition(epochs_.begin(), epochs_.end(),
                        [](const auto& one) { return one.second.blocks.empty(); });
}

EpochCheck::Epoch& EpochCheck::find_or_add(NodeEpoch key) {
  for (auto& [known, epoch] : epochs_)
    if (known == key) return epoch;
  return epochs_.emplace_back(key, Epoch{}).second;
}

void EpochCheck::add(const SealedBlock& block) {
  Epoch& epoch = find_or_add({block.header.node, block.header.epoch});
  BlockEntry entry{.sequence = block.header.sequence,
                   .first_scan = block.header.first_scan,
                   .scans = block.header.scans,
                   .crc = crc_of(block),
                   .kind = block.kind,
                   .cause = GapCause::kRingFull};
  if (block.kind == BlockKind::kGap) entry.cause = decode_gap(block).cause;
  if (block.kind == BlockKind::kEnd) epoch.end = decode_end(block);
  if (block.kind == BlockKind::kScan && epoch.period_ps == 0) epoch.period_ps = decode_scan(block).period_ps;
  epoch.blocks.add(entry);
}

bool EpochCheck::covers_numbers_before(const BlockEntry& entry) {
  return entry.kind == BlockKind::kGap && stands_for_lost_blocks(entry.cause);
}

void EpochCheck::check_sequence(const BlockEntry& entry, const BlockEntry* before, VerifiedEpoch& result) {
  if (before && entry.sequence == before->sequence)
    ++(entry.crc == before->crc ? result.repeated_blocks : result.contradicting_blocks);
  if (entry.sequence > result.last_sequence + 1 && !covers_numbers_before(entry))
    result.undeclared_blocks.push_back({result.last_sequence + 1, entry.sequence - 1});
  result.last_sequence = entry.sequence;
}

// The second, independent proof: scan indices run on from block to block and gap to gap.
void EpochCheck::check_scans(const BlockEntry& entry, std::int64_t& next_scan, VerifiedEpoch& result) {
  if (!counts_scans(entry.kind)) return;
  const bool has_scans = entry.kind != BlockKind::kEnd;
  const bool unknown = next_scan == kUnknownScan;
  if (!unknown && entry.first_scan > next_scan)
    result.undeclared_scans.push_back({next_scan, entry.first_scan - 1});
  const bool has_place = entry.scans > 0 || entry.kind == BlockKind::kEnd;
  if (!unknown && entry.first_scan < next_scan && has_place) ++result.overlapping_blocks;
  next_scan = std::max(next_scan, entry.first_scan + (has_scans ? entry.scans : 0));
  if (covers_numbers_before(entry) && entry.scans == 0) next_scan = kUnknownScan;
}

// In a row of gaps one is known to have no scans only if the next one has none either.
void EpochCheck::prove_without_scans(const BlockEntry& entry, VerifiedEpoch& result) {
  if (entry.kind != BlockKind::kScan && entry.kind != BlockKind::kEnd) return;
  for (auto gap = result.gaps.rbegin(); gap != result.gaps.rend(); ++gap) {
    if (gap->scans > 0 || gap->has_no_scans || gap->cause == GapCause::kNodeCrash) return;
    if (gap->first_scan != entry.first_scan) return;
    gap->has_no_scans = true;
  }
}

void EpochCheck::count(const BlockEntry& entry, std::int64_t first_block, VerifiedEpoch& result) {
  ++result.blocks;
  if (entry.kind == BlockKind::kScan) result.samples += entry.scans;
  if (entry.kind != BlockKind::kGap) return;
  result.samples_missing += entry.scans;
  result.gaps.push_back({entry.cause, first_block, entry.sequence, entry.first_scan, entry.scans});
}

// The end block gives the number of scans that a declared loss of unknown length lacks.
void EpochCheck::check_totals(const Epoch& epoch, VerifiedEpoch& result) {
  std::int64_t here = result.samples_deleted + result.samples + result.samples_missing;
  result.ended = epoch.end.has_value() || (epoch.deleted.position.ended && !epoch.deleted.position.crashed);
  result.samples_sent = here;
  if (!epoch.end) return;
  result.samples_sent = epoch.end->scans_sealed + epoch.end->scans_missing;
  const bool has_unknown = std::ranges::any_of(result.gaps, [](const VerifiedGap& gap) {
    return stands_for_lost_blocks(gap.cause) && gap.scans == 0 && !gap.has_no_scans;
  });
  if (has_unknown && here < result.samples_sent) {
    result.samples_missing += result.samples_sent - here;
    here = result.samples_sent;
  }
  if (epoch.end->blocks != epoch.end->header.sequence || result.last_sequence != epoch.end->blocks)
    result.contradictions.push_back("the end is block " + std::to_string(epoch.end->header.sequence) +
                                    " of " + std::to_string(epoch.end->blocks) +
                                    ", the last one here is block " + std::to_string(result.last_sequence));
  if (result.samples_sent != here)
    result.contradictions.push_back("the node took " + std::to_string(result.samples_sent) + " scans, " +
                                    std::to_string(here) + " are recorded or declared missing");
}

// The end's CRC covers the blocks if all are here, once, and as the node sealed them.
void EpochCheck::check_sum(const Epoch& epoch, VerifiedEpoch& result) {
  if (!epoch.end || !epoch.deleted.sum || !result.undeclared_blocks.empty() ||
      result.contradicting_blocks > 0)
    return;
  BlockSum sum(*epoch.deleted.sum);
  std::int64_t last = epoch.deleted.position.contiguous;
  bool is_over = false, has_foreign = false;
  epoch.blocks.in_order([&](const BlockEntry& entry) {
    is_over = is_over || entry.kind == BlockKind::kEnd;
    if (is_over) return;
    has_foreign = has_foreign || (entry.kind == BlockKind::kGap && is_declared_by_host(entry.cause));
    if (entry.sequence > last) sum.add(entry.crc);
    last = std::max(last, entry.sequence);
  });
  if (has_foreign || sum.crc32c() == epoch.end->blocks_crc32c) return;
  char text[160];
  std::snprintf(text, sizeof text,
                "the node's sum of its blocks is %08x, that of those here is %08x: one is another than it "
                "sealed, or in "
                "another's place",
                epoch.end->blocks_crc32c, sum.crc32c());
  result.contradictions.emplace_back(text);
}

void EpochCheck::begin_at_its_first_block(Epoch& epoch) {
  std::int64_t first = 0;
  std::optional<std::int64_t> first_scan;
  epoch.blocks.in_order([&](const BlockEntry& entry) {
    if (first == 0) first = entry.sequence;
    if (!first_scan && counts_scans(entry.kind)) first_scan = entry.first_scan;
  });
  if (first > 1)
    epoch.deleted = {.position = {.contiguous = first - 1, .next_scan = first_scan.value_or(0)},
                     .sum = std::nullopt};
}

VerifiedEpoch EpochCheck::check(NodeEpoch key, Epoch& epoch) {
  VerifiedEpoch result;
  result.node = key.first;
  result.epoch = key.second;
  result.period_ps = epoch.period_ps;
  result.last_sequence = epoch.deleted.position.contiguous;
  result.samples_deleted = epoch.deleted.position.next_scan;
  std::int64_t next_scan = epoch.deleted.position.next_scan;  // counted from the start command on
  bool is_over = epoch.deleted.position.ended;
  std::int64_t blocks_behind_end = 0, first_behind_end = 0;
  std::optional<BlockEntry> before;
  epoch.blocks.in_order([&](const BlockEntry& entry) {
    const bool covers = covers_numbers_before(entry) && entry.sequence > result.last_sequence;
    if (is_over && entry.sequence > result.last_sequence && ++blocks_behind_end == 1)
      first_behind_end = entry.sequence;
    is_over = is_over || ends_its_epoch(entry);
    const std::int64_t first_block = covers ? result.last_sequence + 1 : entry.sequence;
    check_sequence(entry, before ? &*before : nullptr, result);
    check_scans(entry, next_scan, result);
    prove_without_scans(entry, result);
    count(entry, first_block, result);
    before = entry;
  });
  if (blocks_behind_end > 0)
    result.contradictions.push_back(std::to_string(blocks_behind_end) +
                                    " blocks come behind the epoch's end, the first is block " +
                                    std::to_string(first_behind_end));
  check_totals(epoch, result);
  check_sum(epoch, result);
  return result;
}

std::vector<VerifiedEpoch> EpochCheck::result() {
  std::vector<VerifiedEpoch> all;
  for (auto& [key, epoch] : epochs_) {
    if (begins_anywhere_) begin_at_its_first_block(epoch);
    const bool was_over = epoch.blocks.empty() && epoch.deleted.position.ended;
    if (!was_over) all.push_back(check(key, epoch));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const VerifiedEpoch& a, const VerifiedEpoch& b) { return a.node < b.node; });
  return all;
}

}  // namespace roadbalance
