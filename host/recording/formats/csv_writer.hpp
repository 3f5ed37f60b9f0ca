#pragma once

#include <filesystem>
#include <memory>

#include "host/recording/formats/writer.hpp"

namespace roadbalance {

/// Comma-separated values, one table: a row of names (time_s first), a row of units, then a row an instant,
/// with a decimal point and lines that end with "\n".
///
/// A value has one decimal more than is needed to distinguish counts, so that the counts can be computed from
/// it. A cell is empty where there is no sample or it is lost; its row is there.
/// @throws ConfigError if the table has more than one group: its nodes have no common instants
std::unique_ptr<ExportWriter> make_csv_writer(const std::filesystem::path& file, const ExportTable& table);

}  // namespace roadbalance
