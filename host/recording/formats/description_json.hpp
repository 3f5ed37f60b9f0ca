#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/recording/formats/export_table.hpp"

namespace roadbalance {

/// The table as one JSON object: program, vehicle, start, groups with rate_hz, first_s and channels (name,
/// unit, node, scale, offset_counts, mount, position_m, direction, range, delay_s, overload), marks, and
/// samples of nodes that were left out.  value = (counts - offset_counts) * scale.
nlohmann::ordered_json description_of(const ExportTable& table);

/// As text, in ASCII, for formats that allow no more; bytes of a recording's texts that are no UTF-8 are
/// replaced.
std::string as_text(const nlohmann::ordered_json& json);

/// Both, for formats that have room for a text.
std::string description_json(const ExportTable& table);

}  // namespace roadbalance
