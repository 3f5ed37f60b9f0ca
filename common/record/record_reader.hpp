#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/record/log_event.hpp"
#include "common/record/rescue_disk.hpp"

namespace roadbalance {

/// Reads the segments of one recording folder (seg-000001.lcm ...) from the first event on, finished or
/// still growing.  Views returned are valid until the next call.
class RecordReader {
 public:
  /// @param first  number of the segment to begin with, or of the next one that is there
  /// @throws std::system_error naming the folder if it holds no such segment
  explicit RecordReader(std::filesystem::path folder, Disk& disk = rescue_disk(), int first = 1);
  ~RecordReader();
  RecordReader(RecordReader&&) noexcept;

  /// The next complete event; nothing at the present end of the data (a growing record may have more
  /// later: call again).  Damage before the end is skipped by resynchronising and listed in damage().
  std::optional<LogEvent> next();

  /// The record does not grow any more: the bytes left at its end are then given by next(), as far as they
  /// are events that were not torn, or listed in damage().
  void finish();

  /// For the event given last: its segment, and where in it the event begins.
  int segment() const;
  std::uint64_t offset() const;

  struct Damage {
    std::filesystem::path segment;
    std::uint64_t offset;
    std::uint64_t bytes;
    std::string what;  ///< "are ...", "cannot be ..."
    bool torn =
        false;  ///< at the end of the record and never called durable: what a kill or power cut leaves
  };
  /// Where bytes are no events or cannot be read, in order.  Bytes behind the end of an abandoned segment are
  /// not among them: they do not count.
  const std::vector<Damage>& damage() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadbalance
