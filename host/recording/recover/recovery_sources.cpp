#include "host/recording/recover/recovery_sources.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <span>
#include <stdexcept>

#include "common/bus/codec.hpp"
#include "common/record/folder.hpp"
#include "common/record/log_event.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_extent.hpp"
#include "common/record/segment_index.hpp"
#include "host/recording/manifest.hpp"

namespace roadbalance {
namespace {

// "seg-000001.tail", "seg-000001.tail-2" ...
std::vector<std::filesystem::path> cut_tails(const std::filesystem::path& folder, Disk& disk) {
  std::vector<std::filesystem::path> tails;
  for (const std::string& name : list_folder(folder, disk))
    if (name.starts_with("seg-") && name.find(".tail") != std::string::npos) tails.push_back(folder / name);
  std::sort(tails.begin(), tails.end());
  return tails;
}

// Where each torn segment ends; is_torn_tail() distinguishes torn from damaged.
std::map<int, std::uint64_t> torn_tails(const std::filesystem::path& folder, Disk& disk) {
  std::map<int, std::uint64_t> ends;
  const FinishedSegments finished = read_manifest(folder, disk);
  for (const auto& [number, extent] : end_of_record(folder, 1, disk).unfinished)
    if (extent.end > 0 && !finished.contains(segment_path({}, number).string())) ends[number] = extent.end;
  return ends;
}

}  // namespace

RecoverySources::RecoverySources(const std::vector<std::filesystem::path>& folders, Disk& disk)
    : disk_(disk) {
  for (const auto& folder : folders) {
    std::map<int, std::uint64_t> abandoned;
    const auto numbers = segment_numbers(folder, disk);
    const auto torn = torn_tails(folder, disk);
    for (const int number : numbers) abandoned.merge(abandoned_before(segment_path(folder, number), disk));
    for (const int number : numbers) {
      const auto end = abandoned.find(number);
      files_.push_back({segment_path(folder, number),
                        end == abandoned.end() ? std::numeric_limits<std::uint64_t>::max() : end->second,
                        torn.contains(number) ? torn.at(number) : std::numeric_limits<std::uint64_t>::max()});
    }
    for (const auto& tail : cut_tails(folder, disk)) files_.push_back({tail, 0, 0});
  }
}

void RecoverySources::for_each(const Take& take, std::vector<RecordReader::Damage>& damage) const {
  for (std::size_t file = 0; file < files_.size(); ++file) {
    SegmentReader reader(files_[file].path, disk_);
    const std::size_t before = damage.size();
    while (const auto event = reader.next(true, damage))
      take(*event, {.file = file, .offset = reader.offset()}, reader.offset() < files_[file].end);
    for (auto& piece : std::span(damage).subspan(before))
      piece.torn = piece.offset >= files_[file].end || is_torn({.file = file, .offset = piece.offset});
  }
}

SealedBlock RecoverySources::block_at(const Place& place, std::int64_t& timestamp_us) const {
  const File file = File::open_segment(files_[place.file].path, disk_);
  std::vector<std::uint8_t> bytes(kLogHeaderBytes + kMaxLogChannelBytes + kMaxBlockBytes);
  std::vector<File::Unreadable> behind_it;
  bytes.resize(file.read_around(place.offset, bytes, behind_it));
  const ParsedEvent parsed = parse_log_event(bytes);
  SealedBlock block;
  if (parsed.status != ParsedEvent::Status::kEvent || accept(parsed.event.data, block) != Refusal::kNone)
    throw std::runtime_error(files_[place.file].path.string() + ": changed while it was read");
  timestamp_us = parsed.event.timestamp_us;
  return block;
}

}  // namespace roadbalance
