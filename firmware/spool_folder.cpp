#include "firmware/spool_folder.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/folder.hpp"
#include "common/record/log_event.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {

namespace {

constexpr std::chrono::seconds kRetry{1};
constexpr std::uint64_t kShortestSegment = std::uint64_t{64} << 10;
constexpr std::uint64_t kLongestSegment = std::uint64_t{4} << 20;
// The size of the largest block, with the longest name of its channel.
constexpr std::uint64_t kMostEventBytes = kLogHeaderBytes + 24 + kMaxBlockBytes;

// Its name is durable on return, also of one that is there: the program that made it may have been killed
// before this.  Those above it are not made: one that is missing may be a disk that is not mounted.
void make_folder(const std::filesystem::path& folder, Disk& disk) {
  if (!folder.has_filename() && folder.has_relative_path()) return make_folder(folder.parent_path(), disk);
  if (disk.mkdir(folder.c_str(), 0755) != 0 && errno != EEXIST)
    throw std::system_error(errno, std::generic_category(), "mkdir " + folder.string());
  try {
    sync_folder(folder_of(folder), disk);
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::permission_denied) throw;  // else it is not ours, and older than we are
  }
}

void put_event(const LogEvent& event, std::vector<std::uint8_t>& out) {
  const auto header = encode_log_header(event);
  out.insert(out.end(), header.begin(), header.end());
  out.insert(out.end(), event.channel.begin(), event.channel.end());
  out.insert(out.end(), event.data.begin(), event.data.end());
}

}  // namespace

SpoolFolder::SpoolFolder(Options options, Disk& disk)
    : options_(std::move(options)),
      disk_(disk),
      segment_bytes_(std::clamp(options_.bytes / 16, kShortestSegment, kLongestSegment)) {
  if (options_.bytes < kLeastBytes)
    throw std::invalid_argument("spool of " + std::to_string(options_.bytes) + " bytes: at least " +
                                std::to_string(kLeastBytes) + " are needed");
  make_folder(options_.folder, disk_);
  folder_ = File::open_folder(options_.folder, disk_);
  if (!folder_.try_lock())
    throw std::system_error(EBUSY, std::generic_category(), "lock " + options_.folder.string());
}

std::int64_t SpoolFolder::capacity() const {
  return static_cast<std::int64_t>(options_.bytes / kMostEventBytes);
}

std::filesystem::path SpoolFolder::path(int segment) const {
  return segment_path(options_.folder, segment);
}

std::uint64_t SpoolFolder::bytes_used() const {
  std::uint64_t bytes = left_bytes_;
  for (const auto* list : {&segments_, &freed_})
    for (const Segment& segment : *list) bytes += segment.bytes + segment.uncut;
  return bytes;
}

// Number 0 marks a description, which is no block of the epoch.
void SpoolFolder::describe(const SealedBlock& meta) {
  MetaBlock block = decode_meta(meta);
  block.header.sequence = 0;
  SealedBlock sealed;
  seal(block, sealed);
  put_event({.number = 0,
             .timestamp_us = meta.header.time_ns / 1000,
             .channel = block_channel(options_.node, BlockKind::kMeta),
             .data = sealed.bytes()},
            preamble_);
}

void SpoolFolder::put(const SealedBlock& block) {
  batch_offsets_.push_back(static_cast<std::uint32_t>(segments_.back().bytes + batch_.size()));
  put_event({.number = events_++,
             .timestamp_us = block.header.time_ns / 1000,
             .channel = block_channel(options_.node, block.kind),
             .data = block.bytes()},
            batch_);
}

void SpoolFolder::keep(const Ring& ring, std::int64_t first, std::int64_t last, WallTime now) {
  assert(base_ == next_ || first == next_);
  if (waits_ && now < retry_at_) return;
  try {
    remove_freed();
    if (base_ == next_) base_ = next_ = first;
    write_batch(ring, first, last);
  } catch (const std::system_error&) {
    ++failures_;
    retry_at_ = now + kRetry;
    give_up_file();
  }
}

void SpoolFolder::write_batch(const Ring& ring, std::int64_t first, std::int64_t last) {
  const std::uint64_t used = bytes_used();
  std::uint64_t added = 0;
  for (std::int64_t k = first; k <= last; ++k) {
    const bool is_long = !segments_.empty() && segments_.back().bytes + batch_.size() >= segment_bytes_;
    const bool begins = !writer_.is_open() || is_long;
    const std::uint64_t size = kMostEventBytes + (begins ? preamble_.size() : 0);
    if (used + added + size > options_.bytes) break;  // full
    if (begins) {
      if (writer_.is_open()) commit();
      begin_segment(k);
      added += preamble_.size();
    }
    const std::size_t before = batch_.size();
    put(ring.get(k));
    added += batch_.size() - before;
  }
  if (writer_.is_open()) commit();
}

void SpoolFolder::begin_segment(std::int64_t first) {
  writer_ = File::create(path(++last_number_), disk_);
  segments_.push_back({.number = last_number_, .first = first, .offsets = {}, .bytes = 0});
  batch_ = preamble_;
}

// Blocks of the batch are kept: data first, then, of a new file, its name.
void SpoolFolder::commit() {
  Segment& segment = segments_.back();
  if (batch_.empty()) return;
  writer_.write_all(batch_);
  writer_.sync_data();
  if (segment.bytes == 0) folder_.sync();
  segment.bytes += batch_.size();
  segment.offsets.insert(segment.offsets.end(), batch_offsets_.begin(), batch_offsets_.end());
  next_ = segment.next();
  batch_.clear();
  batch_offsets_.clear();
}

// Its good part stays, cut to its length if the disk still does that; a reader stops there anyhow.
void SpoolFolder::give_up_file() {
  const std::uint64_t failed = batch_.size();
  batch_.clear();
  batch_offsets_.clear();
  File file = std::exchange(writer_, File());
  if (!file.is_open()) return;
  Segment& segment = segments_.back();
  segment.uncut = failed;
  if (segment.offsets.empty()) {
    freed_.push_back(std::move(segment));
    segments_.pop_back();
    return;
  }
  try {
    file.truncate(segment.bytes);
    segment.uncut = 0;
  } catch (const std::system_error&) {
    ++failures_;
  }
}

bool SpoolFolder::read(std::int64_t sequence, SealedBlock& out) {
  assert(base_ <= sequence && sequence < next_);
  auto at = std::upper_bound(segments_.begin(), segments_.end(), sequence,
                             [](std::int64_t wanted, const Segment& s) { return wanted < s.first; });
  const Segment& segment = *--at;
  const auto index = static_cast<std::size_t>(sequence - segment.first);
  const bool is_last = index + 1 == segment.offsets.size();
  const std::uint64_t begin = segment.offsets[index];
  event_.resize((is_last ? segment.bytes : segment.offsets[index + 1]) - begin);
  try {
    if (reading_ != segment.number) {
      reader_ = File::open_to_read(path(segment.number), disk_);
      reading_ = segment.number;
    }
    if (reader_.read_at(begin, event_) != event_.size()) return false;
  } catch (const std::system_error&) {
    reading_ = 0;
    ++failures_;
    return false;
  }
  const ParsedEvent parsed = parse_log_event(event_);
  return parsed.status == ParsedEvent::Status::kEvent && accept(parsed.event.data, out) == Refusal::kNone &&
         out.header.node == options_.node && out.header.epoch == options_.epoch &&
         out.header.sequence == sequence;
}

void SpoolFolder::free_through(std::int64_t sequence) {
  assert(sequence < next_);
  if (sequence < base_) return;
  base_ = sequence + 1;
  while (!segments_.empty() && segments_.front().next() <= base_) {
    if (segments_.size() == 1) writer_ = File();
    if (segments_.front().number == reading_) {
      reader_ = File();
      reading_ = 0;
    }
    if (segments_.front().given_up)
      left_bytes_ += segments_.front().bytes + segments_.front().uncut;
    else
      freed_.push_back(std::move(segments_.front()));
    segments_.pop_front();
  }
  remove_freed();
}

void SpoolFolder::give_up_through(std::int64_t sequence) {
  for (Segment& segment : segments_)
    if (segment.first <= sequence) segment.given_up = true;
  free_through(sequence);
}

// Only a write and a sync prove it: bytes read before may be in memory still.
bool SpoolFolder::answers() {
  const auto probe = options_.folder / "probe";
  (void)disk_.unlink(probe.c_str());  // of one that was killed here
  try {
    File file = File::create(probe, disk_);
    file.write_all(std::array<std::uint8_t, 1>{});
    file.sync_data();
  } catch (const std::system_error&) {
    ++failures_;
    return false;
  }
  return disk_.unlink(probe.c_str()) == 0;
}

// A file that cannot be removed is tried again, and takes its space until then.
void SpoolFolder::remove_freed() {
  for (std::size_t k = freed_.size(); k > 0; --k) {
    Segment segment = std::move(freed_.front());
    freed_.pop_front();
    if (disk_.unlink(path(segment.number).c_str()) == 0 || errno == ENOENT) continue;
    ++failures_;
    freed_.push_back(std::move(segment));
  }
}

std::filesystem::path spool_path(const std::filesystem::path& directory, std::int32_t node,
                                 std::int64_t epoch) {
  char name[48];
  std::snprintf(name, sizeof name, "node-%d-%016llx", node, static_cast<unsigned long long>(epoch));
  return directory / name;
}

std::vector<std::filesystem::path> spools_left(const std::filesystem::path& directory,
                                               const std::function<void(const std::string&)>& warn,
                                               Disk& disk) {
  make_folder(directory, disk);
  const auto names = disk.list(directory.c_str());
  if (!names) throw std::system_error(errno, std::generic_category(), "list " + directory.string());
  std::vector<std::filesystem::path> left;
  for (const std::string& name : *names) {
    if (!name.starts_with("node-")) continue;
    const auto folder = directory / name;
    try {
      if (File::open_folder(folder, disk).try_lock() && !segment_numbers(folder, disk).empty())
        left.push_back(folder);
    } catch (const std::system_error& error) {  // its content is unknown; measuring goes on
      warn(std::string("not looked into: ") + error.what());
    }
  }
  std::sort(left.begin(), left.end());
  return left;
}

}  // namespace roadbalance
