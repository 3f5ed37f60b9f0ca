#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "host/recording/formats/export_table.hpp"
#include "host/recording/formats/writer.hpp"

namespace roadbalance {

/// The rows of one group of a recording, in order, a few thousand at a time.
///
/// Each node epoch has a reader of its own, so that samples that came late (repaired after an hour without a
/// network, or sent after a restart of the node) force no others into memory.
class RowStream {
 public:
  static constexpr std::int64_t kRows = 4096;  ///< at a time; fewer at the end

  /// @param table  of this recording; outlives the stream
  /// @throws std::system_error if the folder cannot be read
  RowStream(const std::filesystem::path& folder, const ExportTable& table, std::size_t group);
  ~RowStream();

  /// The next rows, valid until the next call; none behind the last.
  ExportRows next();
  /// Rows so far in which a node's samples were missing, summed over nodes.
  std::int64_t missing() const { return missing_; }

 private:
  class NodeBlocks;

  std::int64_t fill(NodeBlocks& blocks, std::int64_t begin, std::int64_t end);
  void copy(const NodeBlocks& blocks, std::int64_t row, std::int64_t begin);
  void fill_times(std::int64_t begin);

  const ExportTable& table_;
  const ExportGroup& group_;
  std::vector<std::unique_ptr<NodeBlocks>> part_;
  std::int64_t nodes_;    ///< of which the parts are
  std::int64_t row_ = 0;  ///< next to give
  std::int64_t last_ns_ = 0;
  std::int64_t missing_ = 0;
  std::vector<std::int32_t> counts_;  ///< [row][channel]
  std::vector<std::int64_t> time_ns_;
};

}  // namespace roadbalance
