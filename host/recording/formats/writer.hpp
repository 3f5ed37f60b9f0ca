#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "host/recording/formats/export_table.hpp"

namespace roadbalance {

/// Consecutive rows of one group.
struct ExportRows {
  std::int64_t first_row = 0;             ///< 0: the group's first to export
  std::span<const std::int64_t> time_ns;  ///< [row], since ExportTable::start_ns, rising
  std::span<const std::int32_t> counts;   ///< [row][channel]; kMissingCounts where there is no sample

  std::size_t rows() const { return time_ns.size(); }
};

/// Writes one file of a format.  The file is complete after close() and useless before.
///
/// Groups come one after another, each with all its rows in order.
/// @throws std::system_error naming the file if it cannot be written
class ExportWriter {
 public:
  ExportWriter() = default;
  ExportWriter(const ExportWriter&) = delete;
  ExportWriter& operator=(const ExportWriter&) = delete;
  virtual ~ExportWriter() = default;

  virtual void add(std::size_t group, const ExportRows& rows) = 0;
  virtual void close() = 0;
};

}  // namespace roadbalance
