#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/record/record_writer.hpp"
#include "common/types/block.hpp"
#include "tools/import/csv_samples.hpp"

namespace roadbalance {

/// The recording that an import makes: the blocks of all nodes side by side, as a recorder would have got
/// them, between them the marks, and at the beginning from which file they are.  It holds what waits for its
/// turn, no more.
class ImportedRecord {
 public:
  /// @param origin    texts of notes: the file that this is made of, its units
  /// @param begin_us  instant of the first sample; nothing stands before it
  ImportedRecord(const std::filesystem::path& folder, std::vector<std::string> origin, std::int64_t begin_us,
                 std::vector<ImportedMark> marks);

  /// Those of a node in their sequence: an edge block bears the time of its first edge, before scans that are
  /// sealed already.  The vehicle's description of all nodes comes before the first write_before().
  /// @param node  position; of two blocks of one instant the lower comes first
  void add(std::size_t node, const SealedBlock& block);
  /// All that came before an instant.
  void write_before(std::int64_t time_us);
  /// The rest; then all is on the disk and described.
  void finish();

 private:
  void begin();
  void put(const Note& note, std::int64_t time_us);
  void put_marks_before(std::int64_t time_us);
  void append(std::string_view channel, std::span<const std::uint8_t> bytes, std::int64_t time_us);

  const std::filesystem::path folder_;
  const std::vector<std::string> origin_;
  RecordWriter record_;
  bool begun_ = false;
  const std::vector<ImportedMark> marks_;
  std::size_t next_mark_ = 0;
  std::multimap<std::pair<std::int64_t, std::size_t>, SealedBlock> waiting_;  ///< by instant and node
  std::vector<std::int64_t> latest_us_;                                       ///< [node]
  const std::int64_t begin_us_;
  std::int64_t written_us_;  ///< of the last event
};

}  // namespace roadbalance
