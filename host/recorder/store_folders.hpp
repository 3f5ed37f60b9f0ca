#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/record/record_writer.hpp"
#include "host/recorder/ballast.hpp"
#include "host/recorder/failure_policy.hpp"
#include "host/recorder/store_options.hpp"

namespace roadbalance {

/// Where the record is written: in its first folder or, from the third failure in a row on, in the fallback;
/// from the start on if the first one is read-only, full, or cannot be read.  A record goes from one folder
/// to the other once and never back, over restarts too: its order stays the folders' order.
///
/// The first folder names the fallback in `continued-in`, at the next start at the latest: a start without
/// that fallback is refused, for it would declare lost what the fallback holds.  The fallback lists in
/// `continues` whose rest it holds: one of another drive is refused, unless the new folder cannot be written
/// at all; then it is taken with a warning, for measuring goes before order.  A first folder that cannot be
/// read at the start stays as it is and counts as empty; a gap in the fallback stands for its content.
///
/// Before and after each sync the paths of folder and segment must lead to the files that are open: a removed
/// file takes all that is written to it and keeps nothing, and a file of a disk that was unmounted keeps it
/// unseen.  After a failure the record is looked for at its path:
/// * Our disk, plugged in anew or repaired: the folder has this recording's incarnation or a later one, no
///   segment that came later, and all that was durable.  Recording goes on in a new segment, and nothing is
///   lost.
/// * Another disk, or the folder beneath the mount point: left alone, for it would take all and hide it once
///   ours is mounted again.  Another mount of the same file system is the same folder, and not noticed.
/// * The same disk, but a person has removed the segment or the folder, and made it again: the rest is
///   recorded, and what was in it is missing, and declared so.  The folder is not made here, for a disk may
///   have been mounted there.
class StoreFolders {
 public:
  /// @param options   live as long as this
  /// @param ballast   of an earlier run: gives way where the disk is full to the last byte
  /// @param warnings  get sentences for people
  /// @throws as RecordingStore
  StoreFolders(Disk& disk, const StoreOptions& options, Ballast& ballast, std::vector<std::string>& warnings);
  StoreFolders(const StoreFolders&) = delete;
  StoreFolders& operator=(const StoreFolders&) = delete;

  /// The one that is written to.
  const std::filesystem::path& folder() const { return fallback_ ? options_.fallback : options_.folder; }
  bool is_fallback() const { return fallback_; }
  /// The recorder's number in this run, stored in the folder.
  std::int64_t incarnation() const { return incarnation_; }
  /// Tails that were cut off at the start: of the first folder, and of the fallback.
  const std::vector<RecordWriter::CutTail>& cut_tails() const { return cut_tails_; }

  const RecordState& holds() const { return writer_->holds(); }
  int segment() const { return writer_->segment(); }
  /// Something was appended to it.
  bool has_open_segment() const { return segment_is_open_; }
  int last_finished_segment() const { return writer_->segment() - (segment_is_open_ ? 1 : 0); }
  /// As RecordWriter counts.
  std::int64_t appended() const { return writer_->appended(); }
  std::int64_t durable() const { return writer_->durable(); }

  // The calls from here on throw std::system_error.

  void append(const SealedBlock& block, std::int64_t timestamp_us);
  void append(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t timestamp_us);
  void sync();
  void close();
  /// As RecordWriter::tidy(), which does not throw.
  bool tidy() { return writer_->tidy(); }

  /// A write or sync failed: the segment is given up if it is lost for writing, or is to be let go of.
  /// @return whether it was
  bool give_up(const FailurePolicy::Decision& decision, const Note& stamp);
  /// It was let go of, and is to be found again before anything is appended.
  bool is_away() const { return writer_->is_away(); }
  /// Finds it again.
  /// @return whether the record was begun anew, for a person has removed what was there
  bool come_back();
  /// @return false: it is there already, there is none, or it cannot be used
  bool go_to_fallback();
  /// At the folder's path is another disk, or nothing.
  bool lies_elsewhere() const;

 private:
  void open_folders();
  void open_first();
  bool is_known_and_missing() const;
  void open(const std::filesystem::path& folder, RecordState before);
  void keep_cut_tail();
  RecordState held_by_first(std::vector<UnsureBlock>& unsure);
  void store_incarnation();
  void say_where_it_goes_on();
  void require_its_place() const;
  bool is_its_disk_there() const;
  bool holds_this_recording() const;
  void begin_anew();

  Disk& disk_;
  const StoreOptions& options_;
  Ballast& ballast_;
  std::vector<std::string>& warnings_;
  std::optional<RecordWriter> writer_;
  bool fallback_ = false;
  std::int64_t device_ = -1;  // that folder() lies on
  std::int64_t incarnation_ = 0;
  std::vector<RecordWriter::CutTail> cut_tails_;
  bool segment_is_open_ = false;
  bool is_removed_ = false;  // the folder or the segment, while its disk was there
};

}  // namespace roadbalance
