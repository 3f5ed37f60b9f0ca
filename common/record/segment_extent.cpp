#include "common/record/segment_extent.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {

SegmentExtent measure_segment(const std::filesystem::path& segment, Disk& disk) {
  SegmentReader reader(segment, disk);
  SegmentExtent extent{.size = File::open_segment(segment, disk).size()};
  std::vector<RecordReader::Damage> damage;
  std::vector<std::uint64_t> bad;  // where something begins that is not as it was written
  while (const auto event = reader.next(true, damage)) {
    if (event->channel.starts_with("RB_") && !event->has_its_crc) bad.push_back(reader.offset());
    const auto commit = event->channel == kCommitChannel ? decode_commit(event->data) : std::nullopt;
    const auto bytes = commit ? static_cast<std::uint64_t>(commit->bytes) : 0;
    if (bytes <= extent.durable || bytes > reader.offset()) continue;
    extent.durable = bytes;
    extent.commit_at = reader.offset();
  }
  for (const auto& piece : damage) bad.push_back(piece.offset);
  extent.end = reader.end_of_events();
  for (const std::uint64_t offset : bad)
    if (offset >= extent.durable) extent.end = std::min(extent.end, offset);
  return extent;
}

std::map<int, std::uint64_t> abandoned_before(const std::filesystem::path& segment, Disk& disk) {
  std::map<int, std::uint64_t> ends;
  SegmentReader reader(segment, disk);
  std::vector<RecordReader::Damage> damage;
  const int own = segment_of_file(segment.filename().string(), ".lcm").value_or(0);
  while (const auto event = reader.next(true, damage)) {
    const auto note = event->channel == kNoteChannel ? decode_note(event->data) : std::nullopt;
    if (!note || note->kind != NoteKind::kSegmentAbandoned) break;
    if (note->a < own) ends[static_cast<int>(note->a)] = static_cast<std::uint64_t>(note->b);
  }
  return ends;
}

}  // namespace roadbalance
