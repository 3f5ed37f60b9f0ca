#include "common/record/take_over.hpp"

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

#include "common/link/planted.hpp"
#include "common/record/folder.hpp"
#include "common/record/header_check.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_events.hpp"
#include "common/record/segment_extent.hpp"
#include "common/record/segment_index.hpp"
#include "common/record/write_again.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kCopyBytes = std::size_t{256} << 10;

// "seg-000001.tail", or "seg-000001.tail-2" and so on: an earlier one is never written over.
std::filesystem::path free_tail_path(std::filesystem::path segment, Disk& disk) {
  segment.replace_extension(".tail");
  std::filesystem::path tail = segment;
  for (int number = 2; path_exists(tail, disk); ++number) {
    tail = segment;
    tail += "-" + std::to_string(number);
  }
  return tail;
}

// The bytes from `offset` on go to a file beside the segment, durably, before the segment is cut.
std::filesystem::path keep_tail(const std::filesystem::path& segment, std::uint64_t offset, File& folder,
                                Disk& disk) {
  const auto tail = free_tail_path(segment, disk);
  const File from = File::open_segment(segment, disk);
  File to = File::create(tail, disk);
  std::vector<std::uint8_t> buffer(kCopyBytes);
  for (;;) {
    const std::size_t got = from.read_at(offset, buffer);
    if (got == 0) break;
    to.write_all({buffer.data(), got});
    offset += got;
  }
  to.sync();
  to.close();
  folder.sync();  // the tail's name too
  return tail;
}

void remove_unnamed(const File& folder, Disk& disk) {
  for (const std::string& name : list_folder(folder.path(), disk))
    if (name.starts_with("seg-") && name.ends_with(".lcm.new")) remove_file(folder.path() / name, disk);
}

// Nothing in a segment without any event was ever promised, and its number is free again.
std::optional<RecordWriter::CutTail> remove_segment(const std::filesystem::path& segment, std::uint64_t size,
                                                    File& folder, Disk& disk) {
  std::optional<RecordWriter::CutTail> result;
  if (size > 0)
    result = {.segment = segment, .tail = keep_tail(segment, 0, folder, disk), .kept = 0, .cut = size};
  remove_file(segment, disk);
  return result;
}

// The commit event that goes with the tail, if it was the one that separates damage before the cut from a
// torn tail, is written again at the cut: else the next reader would end at that damage.  Returns where the
// segment ends now.
std::uint64_t keep_commit(File& segment, const SegmentExtent& extent, Disk& disk) {
  if (extent.commit_at < extent.end) return extent.end;
  SegmentEvents events;
  HeaderCheck headers;
  SegmentReader reader(segment.path(), disk);
  std::vector<RecordReader::Damage> damage;
  for (auto event = reader.next(true, damage); event && reader.offset() < extent.end;
       event = reader.next(true, damage)) {
    headers.take(1, reader.offset(), *event);
    events.event_number = event->number + 1;
    events.last_timestamp_us = event->timestamp_us;
  }
  events.segment_bytes = extent.end;
  events.headers = headers.sum();
  events.put_commit(extent.durable);
  segment.write_all_at(extent.end, events.buffer);
  segment.sync();
  return events.segment_bytes;
}

std::optional<RecordWriter::CutTail> cut(const std::filesystem::path& segment, const SegmentExtent& extent,
                                         File& folder, Disk& disk) {
  std::optional<RecordWriter::CutTail> result;
  File file = File::open_to_write(segment, disk);
  if (extent.end < extent.size && !planted(PlantedFault::kTornTailKept)) {
    result = {.segment = segment,
              .tail = keep_tail(segment, extent.end, folder, disk),
              .kept = extent.end,
              .cut = extent.size - extent.end};
    file.truncate(keep_commit(file, extent, disk));
  }
  // Events behind the last commit were synced, and promised to nodes that have let go of them since, or are
  // in the page cache only, after a kill or a failed sync.  From now on they count.
  write_again(file, std::min(extent.durable, extent.end), disk);
  return result;
}

RecordState read_and_index(const std::filesystem::path& folder, RecordState state, Disk& disk) {
  const auto numbers = segment_numbers(folder, disk);
  const int first = start_from_index(folder, state, disk);
  const auto keep_index = [&](int segment, const RecordState& at) {
    if (segment < first) return;
    try {
      File file = File::open_to_write(segment_path(folder, segment), disk);
      const std::uint64_t bytes = file.size();
      file.truncate(bytes);  // gives back what is reserved behind
      file.close();
      if (knows_of_more(folder, segment, disk)) return;
      write_index(folder, {.segment = segment, .bytes = bytes, .epoch = at.epoch}, disk);
    } catch (const std::system_error&) {
      // The record is good without it; only the next start takes longer.
    }
  };
  // The descriptions stand at the beginning of every segment, of the last one at least.
  read_segments(folder, std::min(first, numbers.back()), state, keep_index, disk);
  return state;
}

}  // namespace

TakenOver take_over(File& folder, RecordState before, Disk& disk) {
  TakenOver result;
  remove_unnamed(folder, disk);
  auto numbers = segment_numbers(folder.path(), disk);
  while (!numbers.empty()) {
    const auto last = segment_path(folder.path(), numbers.back());
    if (read_index(folder.path(), numbers.back(), disk)) break;  // it was finished
    const SegmentExtent extent = measure_segment(last, disk);
    auto cut_here =
        extent.end > 0 ? cut(last, extent, folder, disk) : remove_segment(last, extent.size, folder, disk);
    if (cut_here) result.cut = std::move(cut_here);
    if (extent.end > 0) break;
    numbers.pop_back();
  }
  folder.sync();
  if (numbers.empty()) {
    result.holds = std::move(before);
    return result;
  }
  result.segment = numbers.back();
  result.holds = read_and_index(folder.path(), std::move(before), disk);
  return result;
}

}  // namespace roadbalance
