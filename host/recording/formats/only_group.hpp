#pragma once

#include "host/recording/formats/export_table.hpp"

namespace roadbalance {

/// The group of a format that has room for one set of instants.
/// @throws ConfigError if the table has more than one
const ExportGroup& only_group(const ExportTable& table, const char* format);

}  // namespace roadbalance
