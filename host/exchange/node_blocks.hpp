#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common/bus/codec.hpp"
#include "common/record/record.hpp"
#include "host/analyser/in_sequence.hpp"
#include "host/exchange/epoch_clock.hpp"
#include "host/exchange/export_table.hpp"

namespace roadbalance {

/// The scan blocks of one node epoch, in order, each with its place in its group.
class NodeBlocks {
 public:
  /// @param part  outlives it
  /// @param own_clocks  as in its table
  NodeBlocks(const std::filesystem::path& folder, const ExportPart& part, bool own_clocks);

  struct Placed {
    ScanBlock block;
    std::int64_t first_row = 0;  ///< as rows are counted in the recording

    std::int64_t end_row() const { return first_row + block.header.scans; }
  };
  /// The block at hand; nullptr behind the last.
  const Placed* now() const { return there_ ? &now_ : nullptr; }
  /// Of a row of it, as the recording tells time; nothing: its node's clock is not known there.
  std::optional<std::int64_t> time_ns(std::int64_t row) const {
    return clock_.time_ns(now_.block.row_time_ns(row - now_.first_row));
  }
  const ExportPart& part() const { return part_; }
  void advance();

 private:
  void place();

  RecordReader reader_;
  const ExportPart& part_;
  const std::string scans_;  ///< channel
  EpochClock clock_;
  InSequence in_sequence_;
  SealedBlock sealed_;
  Placed now_;
  bool there_ = true;
};

}  // namespace roadbalance
