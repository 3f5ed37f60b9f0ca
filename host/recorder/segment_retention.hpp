#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "common/record/disk.hpp"

namespace roadbalance {

/// Lists a folder's finished segments in its manifest and, for retention, deletes the oldest of them.  A
/// segment goes only when a note on the disk declares it missing.
class SegmentRetention {
 public:
  /// Puts the note into the record.
  using NoteDeletion = std::function<void(int segment, std::int64_t bytes)>;

  /// @param keep_bytes  as in StoreOptions
  /// @param warnings    get sentences for people
  SegmentRetention(Disk& disk, std::int64_t keep_bytes, NoteDeletion note_deletion,
                   std::vector<std::string>& warnings);

  /// Lists those through `last` and chooses which to delete.  The manifest is for people and for transfer:
  /// one that cannot be written now is written with the next segment.
  /// @return false: nothing was new, or the disk refused
  bool list(const std::filesystem::path& folder, int last);
  /// All notes of deletions are on the disk.
  void notes_are_durable() { notes_are_durable_ = !to_delete_.empty(); }
  /// Deletes one of which a note is on the disk.
  /// @return false: there is none, or the disk refused
  bool delete_one(const std::filesystem::path& folder);
  /// Another folder.
  void begin_anew();

  std::int64_t deleted() const { return deleted_; }

 private:
  void choose(const std::filesystem::path& folder);

  Disk& disk_;
  const std::int64_t keep_bytes_;
  const NoteDeletion note_deletion_;
  std::vector<std::string>& warnings_;
  int listed_ = 0;                  // the last that the manifest lists
  std::set<int> to_delete_;         // a note of each is on the disk after the next commit
  bool notes_are_durable_ = false;  // of all of them
  std::int64_t deleted_ = 0;
};

}  // namespace roadbalance
