#pragma once

#include <filesystem>
#include <memory>

#include "host/exchange/writer.hpp"

namespace roadbalance {

/// Comma-separated values, one table: a row of names (time_s first), a row of units, then a row an instant,
/// with a decimal point and lines that end with "\n".
///
/// A value has one decimal more than tells one count from the next, so that the counts can be computed from
/// it.  A cell that is empty was not measured or is lost; its row is there.
/// @throws ConfigError if the table has more than one group: its nodes have no common instants
std::unique_ptr<ExportWriter> make_csv_writer(const std::filesystem::path& file, const ExportTable& table);

}  // namespace roadbalance
