#include "host/recorder/verify.hpp"

#include <algorithm>
#include <exception>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record.hpp"
#include "common/record/segment.hpp"
#include "host/recorder/manifest.hpp"

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

bool covers_numbers_before(const Entry& entry) {
  return entry.kind == BlockKind::kGap && stands_for_lost_blocks(entry.cause);
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
  std::int64_t next_scan = 0;  // counted from the start command on
  for (const Entry& entry : epoch.entries) {
    check_sequence(entry, result);
    check_scans(entry, next_scan, result);
    count(entry, result);
  }
  check_totals(epoch, result);
  return result;
}

using FinishedSegments = std::map<std::string, std::uint64_t>;  // size by file name

// What no event tells of: a whole segment, or the end of a finished one.
void list_missing_segments(const std::filesystem::path& folder, const FinishedSegments& finished,
                           Verification& result) {
  const auto missing = [&result](const std::string& file, const std::string& what) {
    ++result.missing_segments;
    result.damage.push_back(file + ": " + what);
  };
  for (const auto& [file, bytes] : finished) {
    const auto path = folder / file;
    if (!std::filesystem::exists(path))
      missing(file, "is missing; manifest.json lists it as finished");
    else if (const auto size = std::filesystem::file_size(path); size < bytes)
      missing(file, "has " + std::to_string(size) + " of the " + std::to_string(bytes) +
                        " bytes it was finished with");
  }
  const std::vector<int> numbers = segment_numbers(folder);
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const auto path = segment_path(folder, numbers[k]);
    const std::string file = path.filename().string();
    if (k > 0 && numbers[k] != numbers[k - 1] + 1)
      missing(file, "does not follow " + segment_path(folder, numbers[k - 1]).filename().string());
    if (std::filesystem::file_size(path) > 0 || finished.contains(file)) continue;
    if (k + 1 == numbers.size())
      result.damage.push_back(file + ": is empty: its recorder was killed when it began it");
    else
      missing(file, "is empty");
  }
}

void list_damage(const RecordReader& reader, const FinishedSegments& finished, Verification& result) {
  for (const auto& damage : reader.damage()) {
    const bool torn = damage.torn && !finished.contains(damage.segment.filename().string());
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
    else if (accept(event->data, block) != Refusal::kNone ||
             event->channel != block_channel(block.header.node, block.kind))
      ++result.blocks_refused;
    else if (block.header.sequence > 0)
      add(block, epochs);
  }
}

Verdict judge(const Verification& result) {
  bool damaged = result.blocks_refused > 0 || result.damaged_bytes > 0 || result.missing_segments > 0;
  bool complete = result.damage.empty() && !result.epoch.empty();
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
    if (result.events == 0) throw std::runtime_error(folder.string() + ": no event in it can be read");
    const FinishedSegments finished = read_manifest(folder);
    list_damage(reader, finished, result);
    list_missing_segments(folder, finished, result);
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

std::string verdict_text(const Verification& result) {
  switch (result.verdict) {
    case Verdict::kComplete:
      return "complete";
    case Verdict::kDamaged:
      return "damaged";
    case Verdict::kUnreadable:
      return "unreadable";
    case Verdict::kIncomplete:
      break;
  }
  if (result.epoch.empty()) return "incomplete: it describes itself, but no block of a node is there";
  const bool open = !result.damage.empty() || std::any_of(result.epoch.begin(), result.epoch.end(),
                                                          [](const auto& epoch) { return epoch.is_open(); });
  return open ? "incomplete, no end: what came after is unknown" : "incomplete, every gap declared";
}

}  // namespace roadbalance
