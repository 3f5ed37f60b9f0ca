#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/record/disk.hpp"
#include "common/record/record_state.hpp"
#include "common/record/segment_extent.hpp"

namespace roadbalance {

/// Where the record stands at the end of a finished segment, so that a restart does not read those before.
///
/// A text of lines, "seg-000001.idx" beside the segment:
///
///     roadbalance index 2
///     segment 1 bytes 67108001
///     epoch NODE EPOCH contiguous C next_scan N ended E samples S gaps G blocks B sum D
///     crc32c 89abcdef
///
/// E is 1 for an end, 2 for a declared crash, else 0; D is the sum of blocks (common/types/blocks.hpp) as
/// eight hexadecimal digits, or "none".  It can be made again from the segments at any time, and nothing in
/// it counts more than they do.
struct SegmentIndex {
  int segment = 0;
  std::uint64_t bytes = 0;  ///< length of the segment
  std::map<NodeEpoch, RecordState::Epoch> epoch;

  bool operator==(const SegmentIndex&) const = default;
};

std::string encode(const SegmentIndex& index);
/// Refuses everything that encode() would not write, and numbers beyond kIndexLimit.
std::optional<SegmentIndex> decode_index(std::string_view text);

/// "seg-000001.idx" in `folder`.
std::filesystem::path index_path(const std::filesystem::path& folder, int number);
/// Nothing if there is none, if it is damaged, or if the segment has another length.
std::optional<SegmentIndex> read_index(const std::filesystem::path& folder, int number,
                                       Disk& disk = kernel_disk());
/// The same, however long its segment is now, as of one that the retention mode has deleted.
std::optional<SegmentIndex> read_index_alone(const std::filesystem::path& folder, int number,
                                             Disk& disk = kernel_disk());
/// Where the record in a folder begins.
struct RecordBeginning {
  /// The index of segment 0 where nothing was before; else that of the one deleted last, which may have been
  /// a while before the first one here: numbers were given up.  Nothing: the segments before are in another
  /// folder, or the index is gone.
  std::optional<SegmentIndex> before;
  bool is_in_other_folder = false;
};
RecordBeginning beginning_of(const std::filesystem::path& folder, Disk& disk = kernel_disk());

/// A good index shows that its segment was longer: the segment is wrong, and nothing else shows it.
bool knows_of_more(const std::filesystem::path& folder, int number, Disk& disk = kernel_disk());
/// @throws std::system_error naming the file
void write_index(const std::filesystem::path& folder, const SegmentIndex& index, Disk& disk = kernel_disk());

/// Adds to `state` the newest good index, or that of the segment deleted last if no segment that is there has
/// one.  The larger of two positions of an epoch counts: a record may continue that of another folder, which
/// may have been written to since.
/// @return  number of the first segment that the index does not count; of the first one if there is no index
int start_from_index(const std::filesystem::path& folder, RecordState& state, Disk& disk = kernel_disk());

/// Where a record ends that no program writes to.
struct RecordEnd {
  struct Segment {
    int number = 0;
    SegmentExtent extent;
  };
  int last = 0;  ///< number of the last segment with an event that counts, or `first`
  /// From the last one down: those behind `last`, and that one if it has no index: no writer finished them.
  std::vector<Segment> unfinished;
};
/// @param first  looks no further down than to this segment
RecordEnd end_of_record(const std::filesystem::path& folder, int first = 1, Disk& disk = kernel_disk());

/// The result of rebuild_indexes().
struct RebuiltIndexes {
  int written = 0;  ///< were missing or differed from their segments
  /// Segments at the end whose tail is torn.  They get no index: that would call them finished, and the tail
  /// damage.
  std::vector<std::filesystem::path> torn;
  /// Segments without a good index, where it is not known what was before: their ends are unknown.
  std::vector<std::filesystem::path> unknown;
};
/// Makes those indexes again that are missing or differ from the segments, which it reads all; for a record
/// that no program writes to.  One that knows_of_more() stays, and the first good one where it is not known
/// what was before.
/// @throws std::system_error naming the file
RebuiltIndexes rebuild_indexes(const std::filesystem::path& folder, Disk& disk = kernel_disk());

/// Takes away a finished segment for good, in the retention mode; a note in the record has announced it. Its
/// index stays until the next one goes, to hold where the record begins; it is made now if there is none.
/// @throws std::system_error naming the file
void delete_segment(const std::filesystem::path& folder, int number, Disk& disk = kernel_disk());

}  // namespace roadbalance
