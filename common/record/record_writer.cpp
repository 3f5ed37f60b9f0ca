#include <algorithm>
#include <stdexcept>
#include <utility>

#include "common/record/folder.hpp"
#include "common/record/log_event.hpp"
#include "common/record/record.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {
namespace {

// Space is asked for in these steps, so that a short recording does not take a whole segment's.
constexpr std::uint64_t kReserveBytes = std::uint64_t{16} << 20;
// Appended events wait here for one write(2).
constexpr std::size_t kBufferBytes = std::size_t{256} << 10;

std::uint64_t end_of_last_event(const std::filesystem::path& path, Disk& disk) {
  SegmentReader reader(path, disk);
  std::vector<RecordReader::Damage> damage;
  while (reader.next(true, damage)) {
  }
  return reader.end_of_events();
}

// The bytes from `offset` on go to a file beside the segment, durably, before the segment is cut.
std::filesystem::path keep_tail(const std::filesystem::path& segment, std::uint64_t offset,
                                std::uint64_t size, Disk& disk) {
  std::filesystem::path tail = segment;
  tail.replace_extension(".tail");
  const File from = File::open_to_read(segment, disk);
  remove_file(tail, disk);
  File to = File::create(tail, disk);
  std::vector<std::uint8_t> buffer(kBufferBytes);
  while (offset < size) {
    const std::size_t got = from.read_at(offset, buffer);
    if (got == 0) break;
    to.write_all({buffer.data(), got});
    offset += got;
  }
  to.sync();
  to.close();
  return tail;
}

std::optional<RecordWriter::CutTail> cut_torn_tail(const std::filesystem::path& segment, File& folder,
                                                   Disk& disk) {
  const std::uint64_t size = size_of_file(segment, disk);
  const std::uint64_t kept = end_of_last_event(segment, disk);
  if (kept >= size) return std::nullopt;
  const auto tail = keep_tail(segment, kept, size, disk);
  folder.sync();  // the tail's name too, before the segment is cut
  File file = File::open_to_write(segment, disk);
  file.truncate(kept);
  file.sync();
  return RecordWriter::CutTail{.segment = segment, .tail = tail, .kept = kept, .cut = size - kept};
}

}  // namespace

struct RecordWriter::State {
  State(Options with, Disk& on) : options(std::move(with)), disk(on) {}

  const Options options;
  Disk& disk;
  File folder;
  File file;
  int segment = 0;  // number of the current or, with no file open, of the last segment
  std::uint64_t segment_bytes = 0;
  std::uint64_t reserved_bytes = 0;
  std::int64_t event_number = 0;
  std::int64_t last_timestamp_us = 0;
  std::vector<std::uint8_t> buffer;
  std::vector<std::pair<std::string, std::vector<std::uint8_t>>> preamble;
  std::optional<CutTail> cut;

  void put(const LogEvent& event) {
    const auto header = encode_log_header(event);
    buffer.insert(buffer.end(), header.begin(), header.end());
    buffer.insert(buffer.end(), event.channel.begin(), event.channel.end());
    buffer.insert(buffer.end(), event.data.begin(), event.data.end());
    const std::uint64_t size = header.size() + event.channel.size() + event.data.size();
    segment_bytes += size;
    if (buffer.size() >= kBufferBytes) flush();
  }

  void flush() {
    while (reserved_bytes < segment_bytes) {
      file.reserve(reserved_bytes, kReserveBytes);
      reserved_bytes += kReserveBytes;
    }
    file.write_all(buffer);
    buffer.clear();
  }

  void sync() {
    flush();
    file.sync_data();
  }

  // Space reserved behind the end is given back: a closed segment takes what it holds.
  void close_file(File& which, std::uint64_t size) {
    which.truncate(size);
    which.sync();
    which.close();
  }

  // The present segment's data is durable before the next one's name is there: a power cut leaves a torn tail
  // in the last segment only.  The next one is durable with its preamble before the present one is closed.
  void open_next() {
    if (file.is_open()) sync();
    File before = std::exchange(file, File::create(segment_path(options.folder, segment + 1), disk));
    const std::uint64_t size_before = std::exchange(segment_bytes, 0);
    ++segment;
    reserved_bytes = 0;
    for (const auto& [channel, data] : preamble)
      put({.number = event_number++, .timestamp_us = last_timestamp_us, .channel = channel, .data = data});
    flush();
    file.sync();
    folder.sync();
    if (before.is_open()) close_file(before, size_before);
  }
};

RecordWriter::RecordWriter(Options options, Disk& disk)
    : state_(std::make_unique<State>(std::move(options), disk)) {
  State& s = *state_;
  create_folders(s.options.folder, disk);
  s.folder = File::open_folder(s.options.folder, disk);
  if (!s.folder.try_lock())
    throw std::runtime_error("recording " + s.options.folder.string() + ": another program writes to it");
  s.buffer.reserve(kBufferBytes + kMaxLogEventBytes);
  const auto numbers = segment_numbers(s.options.folder, disk);
  if (numbers.empty()) return;
  s.segment = numbers.back();
  const auto last = segment_path(s.options.folder, s.segment);
  s.cut = cut_torn_tail(last, s.folder, disk);
  // Killed before its first event was there: nothing in it was ever promised, and its number is free again.
  if (size_of_file(last, disk) > 0) return;
  remove_file(last, disk);
  --s.segment;
}

RecordWriter::~RecordWriter() = default;
RecordWriter::RecordWriter(RecordWriter&&) noexcept = default;

void RecordWriter::set_preamble(std::vector<std::pair<std::string, std::vector<std::uint8_t>>> events) {
  state_->preamble = std::move(events);
}

const std::optional<RecordWriter::CutTail>& RecordWriter::cut_tail() const {
  return state_->cut;
}

void RecordWriter::append(std::string_view channel, std::span<const std::uint8_t> data,
                          std::int64_t timestamp_us) {
  State& s = *state_;
  if (channel.empty() || channel.size() > kMaxLogChannelBytes || data.size() > kMaxLogDataBytes)
    throw std::invalid_argument("event on channel " + std::string(channel) + " with " +
                                std::to_string(data.size()) + " bytes does not fit into a record");
  s.last_timestamp_us = timestamp_us;
  const std::uint64_t size = kLogHeaderBytes + channel.size() + data.size();
  if (!s.file.is_open() || s.segment_bytes + size > s.options.segment_bytes) s.open_next();
  s.put({.number = s.event_number++, .timestamp_us = timestamp_us, .channel = channel, .data = data});
}

void RecordWriter::sync() {
  State& s = *state_;
  if (!s.file.is_open()) return;
  s.sync();
}

void RecordWriter::close() {
  State& s = *state_;
  if (!s.file.is_open()) return;
  s.flush();
  s.close_file(s.file, s.segment_bytes);
}

int RecordWriter::segment() const {
  return state_->segment;
}

}  // namespace roadbalance
