#pragma once

#include <filesystem>

#include "host/exchange/export_table.hpp"

namespace roadbalance {

/// Writes the marks as `rb import` takes them: time_s,number,text in order of time, the text in quotes, those
/// in it doubled.
/// @throws std::system_error naming the file
void write_marks(const ExportTable& table, const std::filesystem::path& file);

}  // namespace roadbalance
