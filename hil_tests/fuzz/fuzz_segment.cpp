#include <algorithm>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/notes.hpp"
#include "common/record/log_event.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/record_writer.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "hil_tests/fuzz/built_log.hpp"
#include "hil_tests/fuzz/property.hpp"

// The readers of a record over a folder of arbitrary segments, and the writer that continues it.
namespace roadbalance {
namespace {

using fuzz::Bytes;
using fuzz::require;

fuzz::Reached events("an event");
using test::SimulatedDisk;
constexpr const char* kFolder = "/record";

struct Content {
  std::vector<Bytes> events;
  std::vector<bool> is_commit;  ///< which the writer adds, of each
  std::uint64_t event_bytes = 0;
  std::uint64_t damaged_bytes = 0;
};

Content read(SimulatedDisk& disk) {
  Content content;
  RecordReader reader(kFolder, disk);
  reader.finish();
  while (const auto event = reader.next()) {
    content.events.emplace_back(event->data.begin(), event->data.end());
    content.is_commit.push_back(event->channel == kCommitChannel);
    content.event_bytes += kLogHeaderBytes + event->channel.size() + event->data.size();
  }
  for (const auto& damage : reader.damage()) content.damaged_bytes += damage.bytes;
  return content;
}

void check(std::span<const std::uint8_t> bytes) {
  fuzz::ByteReader in(bytes);
  const std::uint8_t how = in.byte();
  const bool built = how & 1;
  Bytes log;
  if (built)
    log = fuzz::build_log(in);
  else
    log.assign(bytes.begin() + std::min<std::ptrdiff_t>(1, std::ssize(bytes)), bytes.end());

  SimulatedDisk disk;
  disk.mkdir(kFolder, 0755);
  const std::size_t cut = how & 2 ? log.size() / 2 : log.size();
  const auto middle = log.begin() + static_cast<std::ptrdiff_t>(cut);
  disk.put("/record/seg-000001.lcm", Bytes(log.begin(), middle));
  if (cut < log.size()) disk.put("/record/seg-000002.lcm", Bytes(middle, log.end()));

  const Content before = read(disk);
  if (!before.events.empty()) events.count();
  require(before.event_bytes + before.damaged_bytes == log.size(), "every byte is an event's or damage");
  if (built)
    require(std::none_of(before.events.begin(), before.events.end(), fuzz::is_false_block), "no false block");

  RecordWriter writer({.folder = kFolder, .segment_bytes = 4096}, disk);
  const SealedBlock more = fuzz::kLogNode.block(1 << 10);
  for (int k = 0; k < 4; ++k) writer.append(block_channel(fuzz::kLogNode.node, more.kind), more.bytes(), 3);
  writer.close();
  const Content after = read(disk);
  require(after.events.size() >= before.events.size(), "a writer that continues loses no event");
  const auto added = after.is_commit.begin() + std::ssize(before.events);
  require(std::count(added, after.is_commit.end(), false) == 4, "and none of its own");
  require(std::equal(before.events.begin(), before.events.end(), after.events.begin()), "and alters none");
  require(after.damaged_bytes <= before.damaged_bytes, "and adds no damage");
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  roadbalance::check({data, size});
  return 0;
}
