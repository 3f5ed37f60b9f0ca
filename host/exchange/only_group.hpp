#pragma once

#include "host/exchange/export_table.hpp"

namespace roadbalance {

/// The group of a format that has room for one set of instants.
/// @throws ConfigError if the table has more of them
const ExportGroup& only_group(const ExportTable& table, const char* format);

}  // namespace roadbalance
