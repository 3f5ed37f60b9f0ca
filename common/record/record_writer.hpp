#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "common/bus/codec.hpp"
#include "common/bus/notes.hpp"
#include "common/record/disk.hpp"
#include "common/record/record_state.hpp"

namespace roadbalance {

/// Appends events to the segments of a recording folder.  Implements the writing rules of the record:
/// write(2) with results checked, preallocation, directory sync, group commit by the caller.
///
/// A new segment gets its name when its first events and all of the one before are on the disk: a power cut
/// tears the last segment only.  The rest of the work on the one before, its index and the space reserved
/// behind its end, can wait: tidy() does it when there is time.
///
/// A disk that fails: append, sync and close throw std::system_error, and has_failed() shows whether the
/// segment being written is lost for further writing.  Then call abandon(), append again what durable() does
/// not count, and go on; it is the disk's turn.  If has_failed() is false nothing is lost: the same call may
/// be made again.
///
/// A disk that is unmounted while it is written keeps what was written, out of sight; where it was mounted
/// lies a folder of another one.  No segment begins there: append() throws ENODEV; and is_at_its_place() is
/// to be asked between sync() and reporting that something is durable.  Then call let_go(), and take_again()
/// until the disk is back.
class RecordWriter {
 public:
  struct Options {
    std::filesystem::path folder;
    std::uint64_t segment_bytes = 64ULL << 20;
  };
  /// Creates the folder, or continues one: the tail of its last segment is cut to the longest valid prefix
  /// (the rest kept beside it), all that is left is synced, and a new segment begins.
  /// @param before  what the record continues, if it is the continuation of one in another folder
  /// @throws std::system_error naming the file, std::runtime_error if another recorder writes to the folder
  explicit RecordWriter(Options options, Disk& disk = kernel_disk(), RecordState before = {});
  ~RecordWriter();
  RecordWriter(RecordWriter&&) noexcept;
  RecordWriter& operator=(RecordWriter&&) noexcept;

  /// Makes the events to begin a segment with, from the record's contents by then.
  using Preamble = std::function<RecordEvents(const RecordState& holds)>;
  /// Before the first append.  Behind these events the writer repeats the record's clocks.
  void set_preamble(Preamble preamble);

  /// The tail that the constructor cut off the folder's last segment.
  struct CutTail {
    std::filesystem::path segment;
    std::filesystem::path tail;  ///< the bytes cut off, kept here
    std::uint64_t kept = 0;
    std::uint64_t cut = 0;
  };
  const std::optional<CutTail>& cut_tail() const;

  /// The contents of the record now, appended or found there by the constructor.
  const RecordState& holds() const;

  /// @throws std::system_error: what was appended since the last sync may be lost
  void append(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t timestamp_us);
  void append(const SealedBlock& block, std::int64_t timestamp_us);
  /// fdatasync (and the directory's sync for a new file).  After it returned, all appended is durable.
  void sync();
  /// Finishes the segment before the one being written, which the next segment and close() do at the latest.
  /// Takes three syncs; a disk that fails at it takes nothing from the record.
  /// @return  false if there is nothing to do
  bool tidy();
  /// Syncs and closes; a writer that is not closed leaves what a kill would leave.
  void close();

  /// Calls of append() that returned, and how many of these events are on the disk: also without a call of
  /// sync(), for a new segment syncs the one before.
  std::int64_t appended() const;
  std::int64_t durable() const;

  /// True: the segment being written must be abandoned.
  bool has_failed() const;
  /// Gives up the segment being written; it is never written to again, and never synced.  It is cut to what
  /// is on the disk if the disk lets us, and removed if that is nothing; and the segment begun next notes
  /// where it ends (NoteKind::kSegmentAbandoned), so that readers ignore what lies behind.  appended() and
  /// holds() go back to what is durable.  Never throws.
  /// @param stamp  its times and incarnation go into that note
  void abandon(const Note& stamp);

  /// Whether the paths of the folder and of the segment being written lead to what this writer has open.
  /// @throws std::system_error naming the one that cannot be looked at
  bool is_at_its_place() const;
  /// Gives up the segment being written, failed or not, and closes all that is open of the disk.  Never
  /// throws.
  void let_go(const Note& stamp);
  /// After let_go(), or when a sync of the folder failed: nothing can be appended until take_again().
  bool is_away() const;
  /// Takes what the folder's path leads to now, if that holds all of this record that is durable, as the same
  /// disk does wherever it is plugged in.  @return false: it does not
  /// @throws std::system_error naming the file: EBUSY if another recorder writes to it, or has since
  bool take_again();

  /// Number of the segment being written; those before are finished.
  int segment() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadbalance
