#pragma once

#include <cassert>
#include <cerrno>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/link/planted.hpp"
#include "common/record/alter_blocks.hpp"
#include "common/record/folder.hpp"
#include "common/record/log_event.hpp"
#include "common/record/record.hpp"
#include "common/record/record_folder.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_events.hpp"
#include "common/record/written_segment.hpp"

namespace roadbalance {

/// The segment being written and how it is followed by the next.
struct RecordWriter::State : SegmentEvents {
  /// Space is asked for in these steps, so that a short recording does not take a whole segment's.
  static constexpr std::uint64_t kReserveBytes = std::uint64_t{16} << 20;
  /// Appended events wait here for one write(2).
  static constexpr std::size_t kBufferBytes = std::size_t{256} << 10;

  State(Options with, Disk& on) : options(std::move(with)), disk(on) {}

  const Options options;
  Disk& disk;
  RecordFolder folder;
  File file;
  std::optional<WrittenSegment> written;  // the one before, until it is finished
  int segment = 0;                        // number of the current or, with no file open, of the last segment
  std::uint64_t durable_bytes = 0;        // of the segment
  std::uint64_t reserved_bytes = 0;
  std::int64_t appended = 0;
  std::int64_t durable = 0;
  bool failed = false;
  bool may_have_next = false;  // a rename that failed may have happened
  bool commit_due = false;     // the next event is to say what is durable
  Preamble preamble = [](const RecordState&) { return RecordEvents(); };
  std::vector<Note> abandoned;  // not yet said durably
  std::optional<CutTail> cut;
  RecordState before_it;  // what the record continues
  RecordState holds;
  std::map<NodeEpoch, std::optional<RecordState::Epoch>> before;  // as of the last sync, where it was another
  RecordedClocks durable_clocks;
  bool clocks_changed = false;  // since the last sync
  AlterBlocks altered;

  void flush(File& into) {
    while (reserved_bytes < segment_bytes) {
      into.reserve(reserved_bytes, kReserveBytes);
      reserved_bytes += kReserveBytes;
    }
    into.write_all(buffer);
    buffer.clear();
  }

  // A call on the segment being written: if it fails there is no second one.
  template <typename Call>
  void attempt(Call&& call) {
    assert(!failed && "abandon() comes first");
    failed = true;
    call();
    failed = false;
  }

  void sync_data() {
    if (!planted(PlantedFault::kRetryFailedSync)) return file.sync_data();
    try {
      file.sync_data();
    } catch (const std::system_error&) {
      file.sync_data();
    }
  }

  void all_is_durable() {
    commit_due = durable_bytes < segment_bytes;
    durable_bytes = segment_bytes;
    durable = appended;
    before.clear();
    if (std::exchange(clocks_changed, false)) durable_clocks = holds.clocks;
  }

  void sync() {
    attempt([this] {
      flush(file);
      sync_data();
    });
    all_is_durable();
  }

  // All of it is on the disk, so that nothing of what fails here matters.
  bool tidy() {
    if (!written) return false;
    WrittenSegment last = *std::exchange(written, std::nullopt);
    try {
      last.finish(options.folder, disk);
    } catch (const std::system_error&) {
    }
    return true;
  }

  // The present segment, all of which is on the disk.
  WrittenSegment give_up_present(std::uint64_t bytes) {
    return {.file = std::exchange(file, File()),
            .index = {.segment = segment, .bytes = bytes, .epoch = holds.epoch}};
  }

  std::filesystem::path path(int number) const { return segment_path(options.folder, number); }

  bool is_at_its_place() const {
    return folder.is_at(options.folder) && (!file.is_open() || file.is_at(path(segment)));
  }

  // A segment that is on the disk with its first events, under a name that no reader takes.
  File prepare_next(const std::filesystem::path& unnamed) {
    remove_file(unnamed, disk);
    File next = File::create(unnamed, disk);
    segment_bytes = reserved_bytes = 0;
    buffer.clear();
    for (const Note& note : abandoned) put(kNoteChannel, encode(note));
    for (const auto& [channel, data] : preamble(holds)) put(channel, data);
    for (const auto& [channel, data] : clocks_going_on(holds)) put(channel, data);
    flush(next);
    next.sync();
    return next;
  }

  void open_next() {
    if (!is_at_its_place())
      throw std::system_error(ENODEV, std::generic_category(), "recording " + options.folder.string());
    if (file.is_open()) {
      put_last_commit(durable_bytes);
      sync();
    }
    (void)tidy();
    const std::uint64_t size_before = segment_bytes, reserved_before = reserved_bytes;
    const HeaderSum headers_before = std::exchange(headers, {});
    auto unnamed = path(segment + 1);
    unnamed += ".new";
    File next;
    try {
      next = prepare_next(unnamed);
      may_have_next = true;
      rename_file(unnamed, path(segment + 1), disk);
    } catch (...) {
      buffer.clear();  // the present segment is as it was, and can be gone on with
      segment_bytes = size_before;
      reserved_bytes = reserved_before;
      headers = headers_before;
      (void)disk.unlink(unnamed.c_str());
      throw;
    }
    if (file.is_open()) written = give_up_present(size_before);
    file = std::move(next);
    ++segment;
    may_have_next = false;
    durable_bytes = 0;
    if (!planted(PlantedFault::kNoFolderSync)) attempt([this] { folder.sync(); });
    all_is_durable();
    commit_due = false;
    abandoned.clear();
  }

  void remember(const NodeEpoch& key) {
    if (before.contains(key)) return;
    const auto known = holds.epoch.find(key);
    before.emplace(key, known == holds.epoch.end() ? std::nullopt : std::optional(known->second));
  }

  void append(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t timestamp_us) {
    assert(!failed && "abandon() comes first");
    if (channel.empty() || channel.size() > kMaxLogChannelBytes || data.size() > kMaxLogDataBytes)
      throw std::invalid_argument("event on channel " + std::string(channel) + " with " +
                                  std::to_string(data.size()) + " bytes does not fit into a record");
    last_timestamp_us = timestamp_us;
    const std::uint64_t size = kLogHeaderBytes + channel.size() + data.size();
    const std::uint64_t commits = 2 * commit_event_bytes();  // one now and the last one
    if (!file.is_open() || segment_bytes + size + commits > options.segment_bytes) open_next();
    if (std::exchange(commit_due, false)) put_commit(durable_bytes);
    put(channel, data);
    if (buffer.size() >= kBufferBytes) attempt([this] { flush(file); });
    ++appended;
  }

  void append_other(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t timestamp_us) {
    append(channel, data, timestamp_us);
    clocks_changed = clocks_changed || channel == kNoteChannel || channel.starts_with(kClockChannels);
    static_cast<void>(holds.clocks.take(channel, data));
  }

  void append(const SealedBlock& block, std::int64_t timestamp_us) {
    append(block_channel(block.header.node, block.kind), block.bytes(), timestamp_us);
    remember({block.header.node, block.header.epoch});
    add(block, holds);
  }
};

}  // namespace roadbalance
