#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/record/disk.hpp"

namespace roadbalance {

/// One event of an LCM event log: sync word 0xEDA1DA01, number, microseconds, channel, payload.
struct LogEvent {
  std::int64_t number = 0;
  std::int64_t timestamp_us = 0;
  std::string_view channel;
  std::span<const std::uint8_t> data;
};

/// Reads the segments of one recording folder (seg-000001.lcm ...) from the first event on, finished or
/// still growing.  Views returned are valid until the next call.
class RecordReader {
 public:
  /// @throws std::system_error naming the folder if it holds no segment
  explicit RecordReader(std::filesystem::path folder, Disk& disk = kernel_disk());
  ~RecordReader();
  RecordReader(RecordReader&&) noexcept;

  /// The next complete event; nothing at the present end of the data (a growing record may have more
  /// later: call again).  Damage before the end is skipped by resynchronising and listed in damage().
  std::optional<LogEvent> next();

  /// Says that the record does not grow any more: what is left at its end is then given by next(), as far as
  /// it is events, or listed in damage().
  void finish();

  struct Damage {
    std::filesystem::path segment;
    std::uint64_t offset;
    std::uint64_t bytes;
    std::string what;
  };
  const std::vector<Damage>& damage() const;
  /// True if no segment follows this one.
  bool is_last(const std::filesystem::path& segment) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Appends events to the segments of a recording folder.  Implements the writing rules of the record:
/// write(2) with results checked, preallocation, directory sync, group commit by the caller.
class RecordWriter {
 public:
  struct Options {
    std::filesystem::path folder;
    std::uint64_t segment_bytes = 64ULL << 20;
  };
  /// Creates the folder, or continues one: the tail of its last segment is cut to the longest valid prefix
  /// (the rest kept beside it) and a new segment begins.  A last segment without any event is taken away.
  /// @throws std::system_error naming the file, std::runtime_error if another recorder writes to the folder
  explicit RecordWriter(Options options, Disk& disk = kernel_disk());
  ~RecordWriter();
  RecordWriter(RecordWriter&&) noexcept;

  /// Event to begin every segment with; set before the first append and whenever it changes.
  void set_preamble(std::vector<std::pair<std::string, std::vector<std::uint8_t>>> events);

  /// What the constructor cut off the folder's last segment.
  struct CutTail {
    std::filesystem::path segment;
    std::filesystem::path tail;  ///< the bytes cut off, kept here
    std::uint64_t kept = 0;
    std::uint64_t cut = 0;
  };
  const std::optional<CutTail>& cut_tail() const;

  /// @throws std::system_error: what was appended since the last sync may be lost
  void append(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t timestamp_us);
  /// fdatasync (and the directory's sync for a new file).  After it returned, all appended is durable.
  void sync();
  /// Syncs and closes; a writer that is not closed leaves what a kill would leave.
  void close();

  /// Number of the segment being written; those before are finished.
  int segment() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadbalance
