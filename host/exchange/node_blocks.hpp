#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common/bus/codec.hpp"
#include "common/record/record.hpp"
#include "host/analyser/in_sequence.hpp"
#include "host/exchange/export_table.hpp"

namespace roadbalance {

/// The scan blocks of one node epoch, in order, each with its place in its group.
class NodeBlocks {
 public:
  /// @param part  outlives it
  NodeBlocks(const std::filesystem::path& folder, const ExportPart& part);

  struct Placed {
    ScanBlock block;
    std::int64_t first_row = 0;        ///< as rows are counted in the recording
    std::optional<ClockFit> fit = {};  ///< that tells its time; nothing: its node's own time will do

    std::int64_t end_row() const { return first_row + block.header.scans; }
    /// As the recording tells time.
    std::int64_t time_ns(std::int64_t row) const {
      const std::int64_t node_ns = block.row_time_ns(row - first_row);
      return fit ? fit->host_time_ns(node_ns) : node_ns;
    }
  };
  /// The block at hand; nullptr behind the last.
  const Placed* now() const { return there_ ? &now_ : nullptr; }
  const ExportPart& part() const { return part_; }
  void advance();

 private:
  void place();

  RecordReader reader_;
  const ExportPart& part_;
  const std::string scans_, fits_;  ///< channels
  std::optional<ClockFit> fit_;     ///< that came last
  InSequence in_sequence_;
  SealedBlock sealed_;
  Placed now_;
  bool there_ = true;
};

}  // namespace roadbalance
