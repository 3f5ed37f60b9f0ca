#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include "common/record/folder.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/segment.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "hil_tests/fuzz/built_log.hpp"
#include "hil_tests/fuzz/kept_record.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/recorder/recording_store.hpp"
#include "host/recording/recover/recover.hpp"
#include "host/recording/verify/verify.hpp"

// The core of rb recover: over a damaged record and a second place that may fill its holes, and over any
// damage to the files of a recorder's record.
namespace roadbalance {
namespace {

using fuzz::require;

fuzz::Reached records("a new record");
using test::SimulatedDisk;

/// Numbers of the node's blocks that a reader of the folder gets, but gaps that stand for holes.
std::set<std::int64_t> sequences_in(const char* folder, SimulatedDisk& disk) {
  std::set<std::int64_t> found;
  RecordReader reader(folder, disk);
  reader.finish();
  SealedBlock block;
  while (const auto event = reader.next())
    if (accept(event->data, block) == Refusal::kNone && block.kind != BlockKind::kGap)
      found.insert(block.header.sequence);
  return found;
}

fuzz::Reached damaged("a damaged record of a recorder"), complete("one that is whole"),
    gone_on("one that goes on");

/// Blocks that a reader gets, each as its node sealed it.
fuzz::Sequences honest_blocks(const char* folder, SimulatedDisk& disk) {
  fuzz::Sequences found;
  if (!is_folder(folder, disk) || segment_numbers(folder, disk).empty()) return found;
  RecordReader reader(folder, disk);
  reader.finish();
  SealedBlock block;
  while (const auto event = reader.next()) {
    if (accept(event->data, block) != Refusal::kNone || block.header.sequence == 0) continue;
    if (block.kind == BlockKind::kGap) continue;  // a hole: no node of these seals one
    const SealedBlock* own = fuzz::kept_block(block.header);
    require(own && std::ranges::equal(own->bytes(), block.bytes()), "no false block");
    found[{block.header.node, block.header.epoch}].insert(block.header.sequence);
  }
  return found;
}

/// Numbers of the marks that a reader gets.
std::set<std::int64_t> marks_in(const char* folder, SimulatedDisk& disk) {
  std::set<std::int64_t> found;
  if (!is_folder(folder, disk) || segment_numbers(folder, disk).empty()) return found;
  RecordReader reader(folder, disk);
  reader.finish();
  while (const auto event = reader.next()) {
    const auto note = event->channel == kNoteChannel ? decode_note(event->data) : std::nullopt;
    if (note && note->kind == NoteKind::kMark) found.insert(note->a);
  }
  return found;
}

bool contains(const fuzz::Sequences& all, const fuzz::Sequences& some) {
  return std::ranges::all_of(some, [&](const auto& of) {
    const auto found = all.find(of.first);
    return found != all.end() && std::ranges::includes(found->second, of.second);
  });
}

std::map<std::string, fuzz::Bytes> files_of(const char* folder, SimulatedDisk& disk) {
  std::map<std::string, fuzz::Bytes> files;
  for (const std::string& name : list_folder(folder, disk))
    files[name] = disk.content(std::string(folder) + "/" + name);
  return files;
}

/// Damage to any file of it never makes a record complete that is not; and what can be read, rb recover
/// keeps.
void check_kept(fuzz::ByteReader& in) {
  SimulatedDisk disk;
  const fuzz::KeptRecord kept = fuzz::KeptRecord::make(in, disk);
  constexpr const char* kFolder = fuzz::KeptRecord::kFolder;
  const int times = fuzz::damage_files(kFolder, in, disk);
  if (times > 0) damaged.count();
  const fuzz::Sequences readable = honest_blocks(kFolder, disk);
  if (times == 0) require(contains(readable, kept.durable), "what was written is there");
  const Verdict before = verify_record(kFolder, disk).verdict;
  if (before == Verdict::kComplete) {
    complete.count();
    require(contains(readable, kept.durable), "a record that lacks a block is not complete");
  }
  if (times == 0 && kept.closed && !readable.empty())
    require(before == (kept.has_all ? Verdict::kComplete : Verdict::kIncomplete), "a record is good");
  const auto original = files_of(kFolder, disk);

  try {
    const Recovered recovered = recover({kFolder}, "/whole", disk);
    require(times > 0 || recovered.lost.empty(), "nothing is lost of what is not damaged");
    require(files_of(kFolder, disk) == original, "the originals stay as they are");
    const fuzz::Sequences whole = honest_blocks("/whole", disk);
    require(contains(whole, readable), "no block that could be read is left out");
    require(std::ranges::includes(marks_in("/whole", disk), marks_in(kFolder, disk)),
            "no mark that could be read is left out");
    const Verdict verdict = verify_record("/whole", disk).verdict;
    require(verdict == Verdict::kComplete || verdict == Verdict::kIncomplete, "each hole is declared");
    require(verdict == Verdict::kIncomplete || recovered.lost.empty(), "what is lost is told");
    require(verdict == Verdict::kIncomplete || contains(whole, kept.durable),
            "what lacks a block is not complete");
  } catch (const std::runtime_error& error) {
    require(error.what()[0] != 0, "a refusal says why");
    require(readable.empty(), "what is refused holds no good block");
  }
  try {
    RecordingStore store(disk, StoreOptions{.folder = kFolder, .reserve_bytes = 0, .ballast_bytes = 0});
    store.set_clocks(0, 0);
    store.begin();
    (void)store.close(WallTime(std::chrono::hours(2)));
    gone_on.count();
  } catch (const std::runtime_error& error) {
    require(error.what()[0] != 0, "a refusal says why");
  }
  require(contains(honest_blocks(kFolder, disk), readable), "a recorder that goes on loses no block");
}

void check(std::span<const std::uint8_t> bytes) {
  fuzz::ByteReader in(bytes);
  constexpr std::uint64_t kOfARecorder = 0x8000;
  const std::uint64_t how = in.number(2);
  if (how & kOfARecorder) return check_kept(in);
  const auto half = static_cast<std::size_t>(how) % (bytes.size() + 1);
  fuzz::ByteReader first(in.take(half));
  const fuzz::Bytes record = fuzz::build_log(first);
  const fuzz::Bytes spool = fuzz::build_log(in);

  SimulatedDisk disk;
  disk.mkdir("/record", 0755);
  disk.mkdir("/spool", 0755);
  disk.put("/record/seg-000001.lcm", record);
  disk.put("/spool/seg-000001.lcm", spool);
  std::set<std::int64_t> readable = sequences_in("/record", disk);
  readable.merge(sequences_in("/spool", disk));
  std::optional<Recovered> made;
  try {
    made = recover({"/record", "/spool"}, "/whole", disk);
  } catch (const std::runtime_error& error) {
    require(error.what()[0] != 0, "a refusal says why");
    require(readable.empty(), "what is refused holds no good block");
  }
  require(disk.content("/record/seg-000001.lcm") == record && disk.content("/spool/seg-000001.lcm") == spool,
          "the originals stay as they are");
  if (!made) return;

  records.count();
  const Recovered& recovered = *made;
  const std::set<std::int64_t> kept = sequences_in("/whole", disk);
  require(std::ranges::includes(kept, readable), "no block that could be read before is left out");
  std::int64_t blocks = 0;
  RecordReader reader("/whole", disk);
  reader.finish();
  SealedBlock block;
  while (const auto event = reader.next()) {
    if (accept(event->data, block) != Refusal::kNone || block.header.sequence == 0) continue;
    ++blocks;  // the gaps that stand for holes included
    const bool is_hole = block.kind == BlockKind::kGap;
    require(is_hole || !fuzz::is_false_block({event->data.begin(), event->data.end()}), "no false block");
  }
  require(blocks == recovered.blocks + recovered.gaps, "it says how many blocks it has written");
  require(reader.damage().empty(), "the new record is not damaged");
  const Verdict verdict = verify_record("/whole", disk).verdict;
  require(verdict == Verdict::kComplete || verdict == Verdict::kIncomplete, "each hole is declared");
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  roadbalance::check({data, size});
  return 0;
}
