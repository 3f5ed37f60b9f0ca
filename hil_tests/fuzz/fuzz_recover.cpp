#include <algorithm>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include "common/record/record.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "hil_tests/fuzz/built_log.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/recorder/verify.hpp"
#include "tools/rb/salvage.hpp"

// The core of rb recover over a damaged record and a second place that may fill its holes.
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

void check(std::span<const std::uint8_t> bytes) {
  fuzz::ByteReader in(bytes);
  const auto half = static_cast<std::size_t>(in.number(2)) % (bytes.size() + 1);
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
  std::optional<Salvaged> made;
  try {
    made = salvage({"/record", "/spool"}, "/whole", disk);
  } catch (const std::runtime_error& error) {
    require(error.what()[0] != 0, "a refusal says why");
    require(readable.empty(), "what is refused holds no good block");
  }
  require(disk.content("/record/seg-000001.lcm") == record && disk.content("/spool/seg-000001.lcm") == spool,
          "the originals stay as they are");
  if (!made) return;

  records.count();
  const Salvaged& salvaged = *made;
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
  require(blocks == salvaged.blocks + salvaged.gaps, "it says how many blocks it has written");
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
