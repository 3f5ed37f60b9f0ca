#pragma once

#include <string>

#include "host/exchange/export_table.hpp"

namespace roadbalance {

/// The table as one JSON object in ASCII, for formats that have room for a text: program, vehicle, start,
/// groups with rate_hz, first_s and channels (name, unit, node, scale, offset_counts, mount, position_m,
/// direction, range, delay_s, overload), marks.  value = (counts - offset_counts) * scale.
std::string description_json(const ExportTable& table);

}  // namespace roadbalance
