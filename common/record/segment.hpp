#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/record/file.hpp"
#include "common/record/record_reader.hpp"

namespace roadbalance {

/// In a fallback folder, before anything else: the folders whose rest it holds, one a line.
inline constexpr const char* kContinuesFile = "continues";
/// In the first folder once the record goes on in the fallback: which that is.
inline constexpr const char* kContinuedInFile = "continued-in";

/// RecordReader::Damage::what of bytes that were read.
inline constexpr const char* kIsNoEvent = "are no event of an LCM log";

/// "seg-000001.lcm" in `folder`.
std::filesystem::path segment_path(const std::filesystem::path& folder, int number);

/// Number of the segment that a file belongs to, "seg-000012.idx" -> 12; nothing: another name, or ending.
std::optional<int> segment_of_file(std::string_view name, std::string_view ending);
/// Numbers of the segments in `folder`, ascending.
std::vector<int> segment_numbers(const std::filesystem::path& folder, Disk& disk = kernel_disk());

/// Reads the events of one segment, which may still grow.
///
/// An event counts if it parses and ends with its own CRC, or if it is followed by the sync word or the
/// present end and no other event is inside of it.  Else the bytes up to the next event that counts are
/// damage.  So are, on a disk whose readers go around them, bytes that cannot be read.
class SegmentReader {
 public:
  explicit SegmentReader(std::filesystem::path path, Disk& disk = kernel_disk());

  /// @param complete  nothing is added any more: bytes that cannot be an event by now are damage
  /// Views are valid until the next call.
  std::optional<LogEvent> next(bool complete, std::vector<RecordReader::Damage>& damage);

  /// For the event given last.
  std::uint64_t offset() const { return event_offset_; }
  /// Just behind it.
  std::uint64_t end_of_events() const { return end_of_events_; }
  /// Bytes from here on do not count; none of them has been given yet.
  void end_at(std::uint64_t offset) { limit_ = offset; }
  const std::filesystem::path& path() const { return file_.path(); }

 private:
  enum class Step { kEvent, kMore, kSkip };
  std::span<const std::uint8_t> unread() const;
  bool refill();
  Step step(LogEvent& event, bool complete);
  void skip();
  bool has_unreadable(std::uint64_t from, std::uint64_t to) const;
  void close_damage(std::vector<RecordReader::Damage>& damage, std::uint64_t end);

  File file_;
  std::unique_ptr<std::uint8_t[]> buffer_;
  std::size_t filled_ = 0;    // bytes of buffer_ that count
  std::size_t at_ = 0;        // place in buffer_ to look at next
  std::uint64_t offset_ = 0;  // of buffer_[0] in the file
  std::uint64_t end_of_events_ = 0;
  std::uint64_t event_offset_ = 0;
  std::uint64_t limit_ = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t accounted_ = 0;  // everything before was given or listed as damage
  std::vector<File::Unreadable> unreadable_;
};

}  // namespace roadbalance
