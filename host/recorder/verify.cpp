#include "host/recorder/verify.hpp"

#include <algorithm>
#include <exception>
#include <map>
#include <optional>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/record/record.hpp"

namespace roadbalance {
namespace {

struct Entry {
  std::int64_t sequence;
  std::int64_t first_scan;
  std::int64_t scans;
  BlockKind kind;
  GapCause cause;
};

struct Epoch {
  std::vector<Entry> entries;
  std::optional<EndBlock> end;
};
// Behind a declared loss of unknown length.
constexpr std::int64_t kUnknownScan = -1;
// By node and order of appearance: an epoch is a random number.
using Epochs = std::vector<std::pair<std::pair<std::int32_t, std::int64_t>, Epoch>>;

Epoch& find_or_add(Epochs& epochs, std::pair<std::int32_t, std::int64_t> key) {
  for (auto& [known, epoch] : epochs)
    if (known == key) return epoch;
  return epochs.emplace_back(key, Epoch{}).second;
}

void add(const SealedBlock& block, Epochs& epochs) {
  Epoch& epoch = find_or_add(epochs, {block.header.node, block.header.epoch});
  Entry entry{.sequence = block.header.sequence,
              .first_scan = block.header.first_scan,
              .scans = block.header.scans,
              .kind = block.kind,
              .cause = GapCause::kRingFull};
  if (block.kind == BlockKind::kGap) entry.cause = decode_gap(block).cause;
  if (block.kind == BlockKind::kEnd) epoch.end = decode_end(block);
  epoch.entries.push_back(entry);
}

// A gap that a recorder declared for blocks gone at the node covers all numbers since the block before it.
bool covers_numbers_before(const Entry& entry) {
  return entry.kind == BlockKind::kGap && entry.cause == GapCause::kLostAtNode;
}

void check_sequence(const Entry& entry, VerifiedEpoch& result) {
  if (entry.sequence == result.last_sequence) ++result.repeated_blocks;
  if (entry.sequence > result.last_sequence + 1 && !covers_numbers_before(entry))
    result.undeclared_blocks.push_back({result.last_sequence + 1, entry.sequence - 1});
  result.last_sequence = entry.sequence;
}

// The second, independent proof: scan indices run on from block to block and gap to gap.
void check_scans(const Entry& entry, std::int64_t& next_scan, VerifiedEpoch& result) {
  const bool has_scans = entry.kind == BlockKind::kScan || entry.kind == BlockKind::kGap;
  if (!has_scans && entry.kind != BlockKind::kEnd) return;
  const bool unknown = next_scan == kUnknownScan;
  if (!unknown && entry.first_scan > next_scan)
    result.undeclared_scans.push_back({next_scan, entry.first_scan - 1});
  if (!unknown && entry.first_scan < next_scan && entry.scans > 0) ++result.overlapping_blocks;
  next_scan = std::max(next_scan, entry.first_scan + (has_scans ? entry.scans : 0));
  if (covers_numbers_before(entry) && entry.scans == 0) next_scan = kUnknownScan;
}

void count(const Entry& entry, VerifiedEpoch& result) {
  ++result.blocks;
  if (entry.kind == BlockKind::kScan) result.samples += entry.scans;
  if (entry.kind != BlockKind::kGap) return;
  result.samples_missing += entry.scans;
  result.gaps.push_back({entry.cause, entry.sequence, entry.first_scan, entry.scans});
}

void check_totals(const Epoch& epoch, VerifiedEpoch& result) {
  result.ended = epoch.end.has_value();
  result.samples_sent = result.samples + result.samples_missing;
  if (!epoch.end) return;
  result.samples_sent = epoch.end->scans_sealed + epoch.end->scans_missing;
  if (epoch.end->blocks != epoch.end->header.sequence || result.last_sequence != epoch.end->blocks)
    result.contradictions.push_back("the end is block " + std::to_string(epoch.end->header.sequence) +
                                    " of " + std::to_string(epoch.end->blocks) +
                                    ", the last one here is block " + std::to_string(result.last_sequence));
  if (result.samples_sent != result.samples + result.samples_missing)
    result.contradictions.push_back("the node took " + std::to_string(result.samples_sent) + " scans, " +
                                    std::to_string(result.samples + result.samples_missing) +
                                    " are recorded or declared missing");
}

VerifiedEpoch check(std::pair<std::int32_t, std::int64_t> key, Epoch& epoch) {
  VerifiedEpoch result;
  result.node = key.first;
  result.epoch = key.second;
  std::stable_sort(epoch.entries.begin(), epoch.entries.end(),
                   [](const Entry& a, const Entry& b) { return a.sequence < b.sequence; });
  std::int64_t next_scan = 0;
  bool first_with_scans = true;
  for (const Entry& entry : epoch.entries) {
    check_sequence(entry, result);
    // Scans are counted from the node's start on, those before the start command are preview.
    if (first_with_scans && entry.kind != BlockKind::kMeta && entry.kind != BlockKind::kEdge) {
      next_scan = entry.first_scan;
      first_with_scans = false;
    }
    check_scans(entry, next_scan, result);
    count(entry, result);
  }
  check_totals(epoch, result);
  return result;
}

void list_damage(const RecordReader& reader, Verification& result) {
  const auto last = reader.damage().empty() ? nullptr : &reader.damage().back();
  for (const auto& damage : reader.damage()) {
    const bool torn = &damage == last && reader.is_last(damage.segment) &&
                      damage.offset + damage.bytes >= std::filesystem::file_size(damage.segment);
    (torn ? result.torn_bytes : result.damaged_bytes) += damage.bytes;
    result.damage.push_back(damage.segment.filename().string() + ": " + std::to_string(damage.bytes) +
                            " bytes from " + std::to_string(damage.offset) + " on are " +
                            (torn ? "a torn tail" : damage.what));
  }
}

void read(RecordReader& reader, Epochs& epochs, Verification& result) {
  SealedBlock block;
  while (const auto event = reader.next()) {
    ++result.events;
    if (!event->channel.starts_with("RB_BLOCK_"))
      ++result.other_events;
    else if (accept(event->data, block) != Refusal::kNone)
      ++result.blocks_refused;
    else if (block.header.sequence > 0)
      add(block, epochs);
  }
}

Verdict judge(const Verification& result) {
  bool damaged = result.blocks_refused > 0 || result.damaged_bytes > 0;
  bool complete = result.torn_bytes == 0 && !result.epoch.empty();
  for (const auto& epoch : result.epoch) {
    damaged = damaged || epoch.is_damaged();
    complete = complete && epoch.is_complete();
  }
  if (damaged) return Verdict::kDamaged;
  return complete ? Verdict::kComplete : Verdict::kIncomplete;
}

}  // namespace

Verification verify_record(const std::filesystem::path& folder) {
  Verification result;
  try {
    RecordReader reader(folder);
    reader.finish();
    Epochs epochs;
    read(reader, epochs, result);
    list_damage(reader, result);
    for (auto& [key, epoch] : epochs) result.epoch.push_back(check(key, epoch));
    std::stable_sort(result.epoch.begin(), result.epoch.end(),
                     [](const VerifiedEpoch& a, const VerifiedEpoch& b) { return a.node < b.node; });
    result.verdict = judge(result);
  } catch (const std::exception& error) {
    result.verdict = Verdict::kUnreadable;
    result.error = error.what();
  }
  return result;
}

}  // namespace roadbalance
