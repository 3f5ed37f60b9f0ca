#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/analysis/twin/twin_record.hpp"

namespace roadbalance {

/// The twin's results for a recording, for people, a line each.
std::vector<std::string> twin_lines(const RecordedTwin& twin);
nlohmann::ordered_json twin_json(const RecordedTwin& twin);

}  // namespace roadbalance
